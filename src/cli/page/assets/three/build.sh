#!/usr/bin/env bash
# Makes three.min.js from the pinned release of three.js: the modules that entry.js names, in one file.
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
cd "$scratch"
npm init --yes >/dev/null
npm install --silent --no-fund --no-audit three@0.180.0 esbuild@0.28.2
cp "$here/entry.js" .
npx esbuild entry.js --bundle --minify --format=esm --legal-comments=inline --outfile="$here/three.min.js"
cp node_modules/three/LICENSE "$here/LICENSE"
