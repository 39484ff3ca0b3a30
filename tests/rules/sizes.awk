# Reads C sources and prints files above `file_wall` lines and functions above `function_wall`, then,
# after a line "--", the distribution of both. A function opens and closes with a brace in the first
# column, which is how the tree is formatted; tables marked "Generated" may be longer.

function flush_file()
{
    if (name == "")
        return
    lengths[++files] = lines
    if (lines > file_wall && !generated)
        printf "%s: %d lines, at most %d\n", name, lines, file_wall
}

function percentile(values, n, p,    i, j, v)
{
    for (i = 2; i <= n; i++) {
        v = values[i]
        for (j = i - 1; j >= 1 && values[j] > v; j--)
            values[j + 1] = values[j]
        values[j + 1] = v
    }
    i = int(n * p + 0.999999)
    return n == 0 ? 0 : values[i < 1 ? 1 : i]
}

FNR == 1 {
    flush_file()
    name = FILENAME
    generated = 0
    inside = 0
}
{ lines = FNR }
/[Gg]enerated/ { generated = 1 }
/^\{/ {
    inside = 1
    opened = FNR
}
/^\}/ && inside {
    inside = 0
    size = FNR - opened - 1
    functions[++count] = size
    if (size > function_wall)
        printf "%s:%d: a function of %d lines, at most %d\n", FILENAME, opened, size, function_wall
}
END {
    flush_file()
    print "--"
    printf "files %d, lines p50 %d, p90 %d; functions %d, lines p50 %d, p90 %d\n", files,
        percentile(lengths, files, 0.5), percentile(lengths, files, 0.9), count,
        percentile(functions, count, 0.5), percentile(functions, count, 0.9)
}
