# Toolchain file: 64-bit ARM on another machine, by the distribution's cross compiler. The libraries of
# that processor lie in SOBOX_ARM64_ROOT, and qemu-user runs what is built; tests/arm64/run makes both.
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(SOBOX_ARM64_ROOT "$ENV{SOBOX_ARM64_ROOT}" CACHE PATH "Libraries and headers of 64-bit ARM")
list(APPEND CMAKE_TRY_COMPILE_PLATFORM_VARIABLES SOBOX_ARM64_ROOT)

set(CMAKE_C_COMPILER aarch64-linux-gnu-gcc)
set(CMAKE_LIBRARY_ARCHITECTURE aarch64-linux-gnu)
set(CMAKE_SYSROOT ${SOBOX_ARM64_ROOT})
set(CMAKE_CROSSCOMPILING_EMULATOR qemu-aarch64;-L;${SOBOX_ARM64_ROOT})

# Programs (lcm-gen) are this machine's, all else is the other one's.
set(CMAKE_FIND_ROOT_PATH ${SOBOX_ARM64_ROOT})
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_PACKAGE ONLY)

# pkg-config looks at the other processor's libraries alone.
set(ENV{PKG_CONFIG_SYSROOT_DIR} ${SOBOX_ARM64_ROOT})
set(ENV{PKG_CONFIG_LIBDIR}
    ${SOBOX_ARM64_ROOT}/usr/lib/aarch64-linux-gnu/pkgconfig:${SOBOX_ARM64_ROOT}/usr/share/pkgconfig)
