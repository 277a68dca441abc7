#!/usr/bin/env bash
# Builds the C interface and installs headers, libraries and punctual.pc: tools/install_c.sh PREFIX
# The crate types stand here and not in Cargo.toml: Cargo cannot make them depend on a feature, and a library without std
# cannot be linked as one of them (it has no panic handler).
set -euo pipefail
[ $# = 1 ] || { echo "usage: $0 PREFIX" >&2; exit 2; }
mkdir -p "$1"
prefix=$(cd "$1" && pwd)
cd "$(dirname "$0")/.."

version=$(sed -n 's/^version = "\(.*\)"$/\1/p' Cargo.toml | head -n 1)
# Before 1.0, a minor version may change the interface.
soname=libpunctual.so.${version%.*}
built=${CARGO_TARGET_DIR:-target}/release

cargo rustc --quiet --lib --release --features capi --crate-type staticlib,cdylib -- -C "link-arg=-Wl,-soname,$soname"

install -d "$prefix/include" "$prefix/lib/pkgconfig"
install -m 644 include/punctual.h include/punctual.hpp "$prefix/include"
install -m 644 "$built/libpunctual.a" "$prefix/lib"
install -m 755 "$built/libpunctual.so" "$prefix/lib/libpunctual.so.$version"
ln -sf "libpunctual.so.$version" "$prefix/lib/$soname"
ln -sf "$soname" "$prefix/lib/libpunctual.so"
# What the standard library of Rust needs of the system (rustc --print native-static-libs).
sed -e "s|@PREFIX@|$prefix|" -e "s|@VERSION@|$version|" -e "s|@PRIVATE@|-lgcc_s -lutil -lrt -lpthread -lm -ldl -lc|" \
  include/punctual.pc.in >"$prefix/lib/pkgconfig/punctual.pc"
