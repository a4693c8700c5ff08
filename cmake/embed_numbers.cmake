# SPDX-License-Identifier: MIT
# cmake -DOUTPUT=file.h -DINPUT=NAME.txt -P embed_numbers.cmake: write the numbers as one C array of this name.
cmake_path(GET INPUT STEM name)
file(READ ${INPUT} text)
string(REGEX REPLACE "#[^\n]*\n" "" text "${text}")
string(STRIP "${text}" text)
string(REPLACE "\n" ",\n" text "${text}")
file(WRITE ${OUTPUT} "/* Generated from presets/${name}.txt by cmake/embed_numbers.cmake: do not edit. */
static const uint16_t ${name}[] = {
${text}};
")
