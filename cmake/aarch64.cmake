# Linux on 64-bit ARM, by the packages of Debian that `scripts/setup --arm` installs.
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(CMAKE_C_COMPILER aarch64-linux-gnu-gcc)
set(CMAKE_CXX_COMPILER aarch64-linux-gnu-g++)
list(APPEND CMAKE_PREFIX_PATH /usr) # headers of FlatBuffers, and its compiler
