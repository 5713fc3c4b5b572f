# 64-bit Windows, by the packages of Debian that `scripts/setup --windows` installs: g++ with the threads of POSIX,
# whose libraries the DLL takes in.
set(CMAKE_SYSTEM_NAME Windows)
set(CMAKE_SYSTEM_PROCESSOR x86_64)
set(CMAKE_C_COMPILER x86_64-w64-mingw32-gcc-posix)
set(CMAKE_CXX_COMPILER x86_64-w64-mingw32-g++-posix)
set(CMAKE_SHARED_LINKER_FLAGS_INIT -static)
list(APPEND CMAKE_PREFIX_PATH /usr) # the compiler of FlatBuffers
# The headers of FlatBuffers are the same everywhere. Those of Linux beside them must not be found.
file(MAKE_DIRECTORY ${CMAKE_BINARY_DIR}/headers)
file(CREATE_LINK /usr/include/flatbuffers ${CMAKE_BINARY_DIR}/headers/flatbuffers SYMBOLIC)
set(FLATBUFFERS_HEADERS ${CMAKE_BINARY_DIR}/headers CACHE PATH "the folder that has flatbuffers/flatbuffers.h")
