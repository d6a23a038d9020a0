#!/bin/bash
# Builds a statically linked program. It needs no library of the machine, and its results are the same bit for bit on every processor of the same
# architecture. The reason is that musl's sin, cos and exp are part of the program, while glibc chooses among several versions by the
# processor's instructions. Run this script in the folder of the crate with the systems. The program takes about 1.3 times as long as a dynamic one.
set -euo pipefail
target=x86_64-unknown-linux-musl
rustup target add "$target"
cargo build --release --target "$target" "$@"
echo "target/$target/release/ (or the workspace's target folder) has it"
