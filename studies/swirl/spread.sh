#!/bin/sh
# How much of a scene's outcome Table I fixes: spread.sh SCENE MEMBERS STEP...
#
# Table I has three decimals. Member n is the scene with every coordinate moved by at most half a unit
# of the third (awk's generator, seed n), observed at the given steps by snapshots.sh.
set -eu

if [ $# -lt 3 ]; then
    echo "usage: spread.sh SCENE MEMBERS STEP..." >&2
    exit 2
fi
here=$(dirname "$0")
scene=$1
members=$2
shift 2
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
mkdir "$folder/data"
table=$(sed -n 's/.*file: \(data\/[a-z0-9_]*\.csv\).*/\1/p' "$scene")
cp "$scene" "$folder/member.yaml"

member=1
while [ "$member" -le "$members" ]; do
    awk -v seed="$member" '
        BEGIN { FS = ","; OFS = ","; srand(seed) }
        /^#/ || /^m/ { print; next }
        {
            $2 = sprintf("%.9f", $2 + (rand() - 0.5) * 1e-3)
            $3 = sprintf("%.9f", $3 + (rand() - 0.5) * 1e-3)
            print
        }' "$(dirname "$scene")/$table" >"$folder/$table"
    echo "member $member"
    sh "$here/snapshots.sh" "$folder/member.yaml" "$@"
    member=$((member + 1))
done
