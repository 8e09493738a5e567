# How everything is compiled: flags hang on the interface target sobox_options, never on globals.

if(NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE Release CACHE STRING "Release, Debug or a sanitizer preset" FORCE)
endif()

# Release keeps assertions: they state facts outside the inner loops and cost nothing there.
set(CMAKE_C_FLAGS_RELEASE "-O2 -g")

set(SOBOX_SANITIZE "" CACHE STRING "Sanitizers to build with: address,undefined or thread")
option(SOBOX_WERROR "Warnings are errors" ON)
option(SOBOX_FUZZ "Fuzz targets with libFuzzer and sanitizers; needs clang" OFF)
if(SOBOX_FUZZ)
  set(SOBOX_SANITIZE address,undefined)
endif()

find_package(OpenMP REQUIRED COMPONENTS C)
find_package(Threads REQUIRED)
find_package(PkgConfig REQUIRED)
pkg_check_modules(GLIB REQUIRED IMPORTED_TARGET glib-2.0>=2.74 gio-unix-2.0)
pkg_check_modules(LCM REQUIRED IMPORTED_TARGET lcm>=1.3.1)
pkg_check_modules(YAML REQUIRED IMPORTED_TARGET yaml-0.1)
pkg_check_modules(SQLITE REQUIRED IMPORTED_TARGET sqlite3)
pkg_check_modules(SODIUM REQUIRED IMPORTED_TARGET libsodium)
pkg_check_modules(JANSSON REQUIRED IMPORTED_TARGET jansson)

add_library(sobox_options INTERFACE)
target_compile_features(sobox_options INTERFACE c_std_11)
target_compile_definitions(sobox_options INTERFACE _GNU_SOURCE SOBOX_VERSION="${PROJECT_VERSION}")
target_include_directories(sobox_options INTERFACE ${CMAKE_SOURCE_DIR})
# Contraction off: a fused multiply-add appears only where it is written, so that the same bits
# come out of every compiler and instruction set.
target_compile_options(sobox_options INTERFACE -ffp-contract=off -fno-math-errno
  -Wall -Wextra -Wshadow -Wstrict-prototypes -Wmissing-prototypes -Wpointer-arith -Wvla -Wundef
  -Wformat=2 -Wwrite-strings -Wimplicit-fallthrough $<$<BOOL:${SOBOX_WERROR}>:-Werror>)
if(SOBOX_SANITIZE)
  target_compile_options(sobox_options INTERFACE -fsanitize=${SOBOX_SANITIZE}
    -fno-omit-frame-pointer -fno-sanitize-recover=all)
  target_link_options(sobox_options INTERFACE -fsanitize=${SOBOX_SANITIZE})
endif()
if(SOBOX_FUZZ)
  target_compile_options(sobox_options INTERFACE -fsanitize=fuzzer-no-link)
endif()
target_link_libraries(sobox_options INTERFACE m)
