# WebAssembly by the packages of Debian 12 that `scripts/setup --wasm` installs: clang, lld and libc++ 19, wasi-libc.
# The module imports nothing but a few calls of WASI, which runtime/web answers.
set(CMAKE_SYSTEM_NAME Generic)
set(CMAKE_SYSTEM_PROCESSOR wasm32)
set(CMAKE_C_COMPILER clang-19)
set(CMAKE_CXX_COMPILER clang++-19)
set(CMAKE_AR llvm-ar-19)
set(CMAKE_RANLIB llvm-ranlib-19)
set(CMAKE_C_COMPILER_TARGET wasm32-wasi)
set(CMAKE_CXX_COMPILER_TARGET wasm32-wasi)
list(APPEND CMAKE_PREFIX_PATH /usr) # headers of FlatBuffers, and its compiler
set(CMAKE_TRY_COMPILE_TARGET_TYPE STATIC_LIBRARY) # programs need the exceptions of runtime/web

# Every browser since 2023 and node 18 have these parts of WebAssembly.
set(features -msimd128 -mbulk-memory -mnontrapping-fptoint -msign-ext -mmutable-globals)
string(JOIN " " CMAKE_C_FLAGS_INIT --sysroot=/usr ${features})
string(JOIN " " CMAKE_CXX_FLAGS_INIT ${CMAKE_C_FLAGS_INIT} -fwasm-exceptions
       -isystem /usr/lib/llvm-19/include/wasm32-wasi/c++/v1)
