# flare_embed(OUTPUT INPUT HEADER FUNCTION)
#
# Has the build write OUTPUT, a C++ source with FUNCTION (declared in HEADER) that returns the bytes
# of INPUT, so that a program needs no file beside it.
set(FLARE_EMBED_SCRIPT ${CMAKE_CURRENT_LIST_DIR}/embed_text.cmake)
function(flare_embed output input header function)
    cmake_path(GET input FILENAME name)
    add_custom_command(
        OUTPUT ${output}
        COMMAND ${CMAKE_COMMAND} -DINPUT=${input} -DOUTPUT=${output} -DHEADER=${header}
            -DFUNCTION=${function} -P ${FLARE_EMBED_SCRIPT}
        DEPENDS ${input} ${FLARE_EMBED_SCRIPT}
        COMMENT "Embedding ${name}"
        VERBATIM)
endfunction()
