# shellcheck shell=bash
# What tests of pages in a real browser share; they source it, DRIFTLAB their own first argument. Sets
# `program`, `chromium` and `work`, a folder that is removed at the end; ends the test as skipped where
# there is no browser.

# shellcheck disable=SC2034 # for those that source it
program=$1
chromium=$(command -v chromium || command -v chromium-browser || command -v google-chrome || true)
if [ -z "$chromium" ]; then
    echo "SKIPPED: chromium is not installed (Debian: apt install chromium)"
    exit 77
fi

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

fail() {
    echo "FAIL: $*" >&2
    exit 1
}

browse() { # HTML OPTION...
    local page=$1
    shift
    timeout 120 "$chromium" --headless --no-sandbox --disable-gpu --no-first-run \
        --disable-background-networking --disable-component-update --disable-sync \
        --disable-dev-shm-usage --hide-scrollbars --user-data-dir="$work/profile" \
        --enable-logging=stderr --virtual-time-budget=20000 --window-size=1280,900 "$@" \
        "file://$page" 2> "$work/log"
}

# For probes: elements of the page, choices from its lists, and what a probe saw told to the frame
# around the page.
cat > "$work/common.js" <<'COMMON'
const all = selector => [...document.querySelectorAll(selector)];
const choose = (list, value) => {
  if (!list || ![...list.options].some(option => option.value === value)) return 0;
  list.value = value;
  list.dispatchEvent(new Event("change"));
  return 1;
};
const tell = seen => {
  const {ready, errors} = document.body.dataset;
  const told = Object.entries(seen).map(pair => pair.join("=")).join(" ");
  parent.postMessage(errors ? "error: " + errors : ready ? told : "not drawn to its end", "*");
};
/* What is saved as a file is kept for the probe: name -> text. */
const saved = new Map();
const blobs = new Map();
URL.createObjectURL = blob => {
  const address = "blob:" + blobs.size;
  blobs.set(address, blob);
  return address;
};
HTMLAnchorElement.prototype.click = function() {
  const {download} = this, blob = blobs.get(this.href);
  if (blob) saved.set(download, blob.text());
};
COMMON

# A frame of its own is as narrow as asked; a window is never narrower than 500 pixels.
look() { # NAME WIDTH [PROBE]: sets `found` to what the probe saw of $work/NAME.html
    local probed=$work/$1-probed.html frame=$work/frame.html
    # Frames by the clock: a browser without a window draws none by itself.
    { sed -e '/^<\/body>$/,$d' -e '/^<head>$/a\
<script>window.requestAnimationFrame = act => setTimeout(() => act(performance.now()), 16);</script>' \
          "$work/$1.html"; echo "<script>"; cat "$work/common.js"
      echo "</script><script>"; cat "${3:-$work/probe.js}"; echo "</script></body></html>"
    } > "$probed"
    cat > "$frame" <<FRAME
<!DOCTYPE html><title>nothing seen</title>
<script>addEventListener("message", event => { document.title = "seen: " + event.data; });</script>
<iframe src="$1-probed.html" style="width: $2px; height: 900px; border: 0"></iframe>
FRAME
    browse "$frame" --dump-dom > "$work/dom" || fail "$1: no browser: $(tail -3 "$work/log")"
    # Probes read many pixels, and are told that there is a faster way.
    if grep ':CONSOLE' "$work/log" | grep -v willReadFrequently; then
        fail "$1 at $2 px: the console has something to say"
    fi
    found=$(sed -n 's/.*<title>\(.*\)<\/title>.*/\1/p' "$work/dom")
    echo "$1 at $2 px: $found"
    [[ $found == "seen: "*=* ]] || fail "$1 at $2 px: $found"
}

value() { # LIST KEY
    [[ " $1 " =~ \ $2=([^ ]*)\  ]] || fail "no $2 in: $1"
    echo "${BASH_REMATCH[1]}"
}

same() { # WHAT KEY EXPECTED
    local seen
    seen=$(value "$found" "$2")
    [ "$seen" = "$3" ] || fail "$1: $2 is $seen, not $3"
}

expect() { # KEY=VALUE ...
    local pair
    for pair in "$@"; do
        [[ " $found " == *" $pair "* ]] || fail "expected $pair in: $found"
    done
}
