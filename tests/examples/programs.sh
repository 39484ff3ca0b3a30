#!/bin/sh
# Runs the programs that embed Cohort: the one that loads a stage must give the command's picture, the
# one that builds a scene two equal ones, and each must say what is wrong and fail where it cannot.
# Usage: sh programs.sh COHORT EMBED_STAGE EMBED_SCENE
set -eu
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

cat > "$work/stage.usda" <<'STAGE'
#usda 1.0
(
    renderSettingsPrimPath = "/Render/Settings"
)
def Camera "Cam"
{
    double3 xformOp:translate = (0, 0, 6)
    uniform token[] xformOpOrder = ["xformOp:translate"]
}
def Sphere "Ball"
{
}
def DistantLight "Sun"
{
    float inputs:intensity = 20000
}
def DomeLight "Sky"
{
}
def Scope "Render"
{
    def RenderSettings "Settings"
    {
        rel camera = </Cam>
        uniform int2 resolution = (48, 32)
    }
}
STAGE

"$2" "$work/stage.usda" "$work/embedded.exr" 4
"$1" render "$work/stage.usda" -o "$work/command.exr" --spp 4 --quiet
"$1" diff "$work/embedded.exr" "$work/command.exr" --tolerance 1e-6
"$3" "$work/one.exr" 4
"$3" "$work/two.exr" 4
"$1" diff "$work/one.exr" "$work/two.exr"
if "$2" "$work/nowhere.usda" "$work/x.exr" 2> "$work/said"; then
    echo "a missing stage goes unnoticed"
    exit 1
fi
grep -q nowhere "$work/said"
if "$3" "$work/no/folder/x.exr" 4 2> "$work/said"; then
    echo "a missing folder goes unnoticed"
    exit 1
fi
test -s "$work/said"
