# Reads C sources given as arguments and prints every include that goes against the order of rooms.
# Prints nothing when all is well.

function rank(list, room,    n, i, names)
{
    n = split(list, names, " ")
    for (i = 1; i <= n; i++)
        if (names[i] == room)
            return i
    return 0
}

function complain(why)
{
    printf "%s:%d: includes \"%s\": %s\n", FILENAME, FNR, target, why
}

BEGIN {
    # Each room may include itself and what stands before it. Rooms joined by '=' pull from each
    # other by design and count as one.
    order["renderer"] = "base math simd sample shims geometry rays accel sort texture shading light film color integrate"
    order["usda_loader"] = "lex parse compose stage"
    order["delegate"] = "index=prims=pass stage_adapter"
    public["renderer"] = " base scene render image "
    public["usda_loader"] = " base usda "
    public["delegate"] = " base scene render image scene_delegate delegate "
    public["cli"] = " base scene render image scene_delegate delegate stage_adapter usda "
    public["examples"] = public["cli"]
    floor["usda_loader"] = " base math "
    floor["delegate"] = " base math "
}

/^[ \t]*#[ \t]*include[ \t]*"/ {
    target = $0
    sub(/^[^"]*"/, "", target)
    sub(/".*$/, "", target)
    split(FILENAME, here, "/")
    parts = split(target, there, "/")
    top = here[1]
    if (there[1] == "cohort") {
        name = there[2]
        sub(/\.h$/, "", name)
        allowed = public[top]
        if (top == "delegate" && (here[2] == "stage_adapter" || here[4] == "stage_adapter.h"))
            allowed = allowed "usda stage_adapter "
        if (top == "renderer" && here[2] == "base")
            allowed = " base "
        if (index(allowed, " " name " ") == 0)
            complain(top " may not see this public header")
        next
    }
    if (parts == 1) # beside the file
        next
    if (top == "cli" || top == "examples") {
        if (there[1] != top)
            complain(top " sees only the public headers and its own")
        next
    }
    list = order[top]
    gsub(/=/, " ", list)
    to = rank(list, there[1])
    if (to == 0) {
        # Implicit shapes become meshes where UsdGeom is known, by the rule of the room that tests it.
        if (target == "geometry/implicit.h" && here[2] == "stage_adapter")
            next
        if (index(floor[top], " " there[1] " ") == 0)
            complain("no room that " top " may use")
        next
    }
    if (here[2] == "include") {
        complain("a public header includes public headers only")
        next
    }
    if (to > rank(list, here[2]) && order[top] !~ ("(^|[ =])" here[2] "=" there[1]) &&
        index(order[top], "=" there[1]) * index(order[top], here[2] "=") == 0)
        complain(there[1] " comes after " here[2])
}
