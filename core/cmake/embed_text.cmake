# Turns the file INPUT into a C++ source OUTPUT that defines the function FUNCTION (with its
# namespace), which returns the file's bytes as a std::string_view; HEADER declares it. The bytes are
# written as numbers: literals have limits of length, and a text may hold any delimiter.
file(READ ${INPUT} bytes HEX)
string(REGEX REPLACE "(..)" "0x\\1," bytes "${bytes}")
string(REPLACE "0x0a," "0x0a,\n" bytes "${bytes}")
file(WRITE ${OUTPUT}.new
    "#include \"${HEADER}\"\n\n"
    "namespace {\nconstexpr unsigned char kBytes[] = {\n${bytes}};\n}  // namespace\n\n"
    "std::string_view ${FUNCTION}() {\n"
    "    return {reinterpret_cast<const char*>(kBytes), sizeof kBytes};\n}\n")
configure_file(${OUTPUT}.new ${OUTPUT} COPYONLY)
file(REMOVE ${OUTPUT}.new)
