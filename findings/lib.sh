# Sourced by each script of this folder: reads its header, installs the packages named there into a temporary folder,
# runs what follows there, and compares what that printed with the header. README.md describes the header.
set -euo pipefail

script=$(cd "$(dirname "$0")" && pwd)/$(basename "$0")
folder=$(mktemp -d)
seen=$folder/.seen
: >"$seen"

part() { # NAME: what the header has under it, without the comment signs
    sed -n '/^#/!q; p' "$script" | awk -v name="# $1:" '
        /^# [A-Z][a-z]+:/ { inside = index($0, name) == 1; sub(/^# [A-Z][a-z]+: ?/, ""); if (inside && $0 != "") print; next }
        inside { sub(/^#   ?/, ""); print }'
}

finish() {
    local status=$?
    trap - EXIT
    kill $(jobs -p) 2>/dev/null || true
    wait 2>/dev/null || true
    cat "$seen"
    if [ "$status" != 0 ]; then
        [ ! -s "$folder/.log" ] || tail -n 20 "$folder/.log" >&2
        echo "$script: ends with $status before it has seen anything to compare" >&2
    elif ! diff -u --label header --label seen <(part Output) "$seen" >&2; then
        echo "$script: what it saw differs from its header" >&2
        status=1
    fi
    rm -rf "$folder"
    exit "$status"
}
trap finish EXIT
trap 'exit 143' INT TERM

observe() { # COMMAND: run it in the temporary folder, two minutes at most; what it prints is compared
    timeout 120 "$@" >>"$seen"
}

install() {
    local from name version python=() node=()
    while read -r from name version; do
        case $from in
        pypi) python+=("$name==$version") ;;
        npm) node+=("$name@$version") ;;
        debian)
            dpkg-query -W -f '${Version}\n' "$name" 2>/dev/null | grep -qxF "$version" ||
                { echo "$script: needs Debian's $name $version" >&2; exit 1; } ;;
        *) echo "$script: $from $name: packages are from pypi, npm or debian" >&2; exit 1 ;;
        esac
    done < <(part Packages)
    if [ "${#python[@]}" != 0 ]; then
        "${PYTHON:-python3}" -m venv "$folder/venv"
        PATH=$folder/venv/bin:$PATH
        pip install --quiet --disable-pip-version-check "${python[@]}" >"$folder/.log" 2>&1
    fi
    if [ "${#node[@]}" != 0 ]; then
        npm install --silent --no-audit --no-fund --prefix "$folder" "${node[@]}" >"$folder/.log" 2>&1
    fi
    rm -f "$folder/.log"
}

unset PYTHONPATH NODE_PATH
cd "$folder"
install
export PATH HOME=$folder PYTHONWARNINGS=ignore
