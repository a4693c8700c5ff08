# SPDX-License-Identifier: MIT
# cmake -DOUTPUT=file.h -DINPUT=sheen_albedo.txt -P embed_sheen_albedo.cmake: write the rows of numbers as a C array.
file(READ ${INPUT} text)
string(REGEX REPLACE "#[^\n]*\n" "" text "${text}")
string(STRIP "${text}" text)
string(REPLACE "\n" "},\n{" text "${text}")
file(WRITE ${OUTPUT} "/* Generated from presets/sheen_albedo.txt by cmake/embed_sheen_albedo.cmake: do not edit. */
enum { SHEEN_N = 32 };
static const uint16_t sheen_table[SHEEN_N][SHEEN_N] = {
{${text}}};
")
