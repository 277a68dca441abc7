#!/usr/bin/env bash
# Builds the C interface and installs headers, libraries, and what pkg-config and CMake need to find them:
# tools/install_c.sh PREFIX
# Nothing that is installed names PREFIX: the folder may be moved or packed.
set -euo pipefail
[ $# = 1 ] || { echo "usage: $0 PREFIX" >&2; exit 2; }
install -d "$1"
prefix=$(cd "$1" && pwd)
cd "$(dirname "$0")/.."

version=$(sed -n 's/^version = "\(.*\)"$/\1/p' Cargo.toml | head -n 1)
# Before 1.0, a minor version may change the interface.
soname=libpunctual.so.${version%.*}
built=${CARGO_TARGET_DIR:-target}/release

if ! said=$(cargo rustc --quiet --package punctual-capi --lib --release --crate-type staticlib,cdylib -- \
  --print native-static-libs -C "link-arg=-Wl,-soname,$soname" 2>&1); then
  printf '%s\n' "$said" >&2
  exit 1
fi
# What the standard library of Rust needs of the system.
system=$(sed -n 's/^note: native-static-libs: //p' <<<"$said")

# Installs tools/c_package/NAME.in as FOLDER/NAME.
fill() {
  sed -e "s|@VERSION@|$version|" -e "s|@SONAME@|$soname|" -e "s|@SYSTEM@|$system|" "tools/c_package/$2.in" |
    install -m 644 /dev/stdin "$1/$2"
}

lib=$prefix/lib
install -d "$prefix/include" "$lib/pkgconfig" "$lib/cmake/punctual"
install -m 644 include/punctual.h include/punctual.hpp "$prefix/include"
install -m 644 "$built/libpunctual_capi.a" "$lib/libpunctual.a"
install -m 755 "$built/libpunctual_capi.so" "$lib/libpunctual.so.$version"
ln -sf "libpunctual.so.$version" "$lib/$soname"
ln -sf "$soname" "$lib/libpunctual.so"
fill "$lib/pkgconfig" punctual.pc
fill "$lib/pkgconfig" punctual-static.pc
fill "$lib/cmake/punctual" punctual-config.cmake
fill "$lib/cmake/punctual" punctual-config-version.cmake
