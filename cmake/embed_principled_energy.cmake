# SPDX-License-Identifier: MIT
# cmake -DOUTPUT=file.h -DINPUT=principled_energy.txt -P embed_principled_energy.cmake: write the numbers as one C array.
file(READ ${INPUT} text)
string(REGEX REPLACE "#[^\n]*\n" "" text "${text}")
string(STRIP "${text}" text)
string(REPLACE "\n" ",\n" text "${text}")
file(WRITE ${OUTPUT} "/* Generated from presets/principled_energy.txt by cmake/embed_principled_energy.cmake: do not edit. */
static const uint16_t energy_table[32 * 32 + 32 + 16 * 16 * 16] = {
${text}};
")
