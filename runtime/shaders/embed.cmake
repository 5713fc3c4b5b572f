# Turns shaders into string constants, so that the player needs no files at run time:
#   cmake -DOUTPUT=shaders.h "-DINPUTS=a.vert;b.frag" -P embed.cmake
# Every constant is named after its input: value.vert -> kShaderValueVert.
set(text "#pragma once\n// Made by runtime/shaders/embed.cmake from the files in that folder.\n\nnamespace penumbra {\n")
foreach(input ${INPUTS})
    get_filename_component(name ${input} NAME)
    set(constant kShader)
    string(REGEX MATCHALL "[a-z0-9]+" words ${name})
    foreach(word ${words})
        string(SUBSTRING ${word} 0 1 first)
        string(SUBSTRING ${word} 1 -1 rest)
        string(TOUPPER ${first} first)
        string(APPEND constant ${first}${rest})
    endforeach()
    file(READ ${input} source)
    string(APPEND text "\ninline constexpr char ${constant}[] = R\"glsl(${source})glsl\";\n")
endforeach()
string(APPEND text "\n}  // namespace penumbra\n")
file(WRITE ${OUTPUT} "${text}")
