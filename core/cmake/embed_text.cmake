# Turns the text file INPUT into a C++ source OUTPUT that defines `std::string_view FUNCTION()`, a
# full name such as flare::SomeText, declared in HEADER. The text is cut into pieces, because
# compilers need not take one literal of more than 64 KiB. ASCII only: a piece ends at a byte.
#
# cmake -DINPUT=... -DOUTPUT=... -DFUNCTION=... -DHEADER=... -P embed_text.cmake
file(READ ${INPUT} text)
string(LENGTH "${text}" length)
set(pieces "")
set(at 0)
while(at LESS length)
    string(SUBSTRING "${text}" ${at} 8000 piece)
    string(APPEND pieces "    R\"text(${piece})text\"\n")
    math(EXPR at "${at} + 8000")
endwhile()
file(WRITE ${OUTPUT}.new
    "#include \"${HEADER}\"\n\nstd::string_view ${FUNCTION}() {\n    return\n${pieces}    ;\n}\n")
configure_file(${OUTPUT}.new ${OUTPUT} COPYONLY)
file(REMOVE ${OUTPUT}.new)
