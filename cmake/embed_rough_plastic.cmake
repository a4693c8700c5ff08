# SPDX-License-Identifier: MIT
# cmake -DOUTPUT=file.h -DINPUT=rough_plastic.txt -P embed_rough_plastic.cmake: write the four blocks of numbers as C arrays.
file(READ ${INPUT} text)
string(REGEX REPLACE "#[^\n]*\n" "" text "${text}")
string(REGEX REPLACE "([0-9])([,\n])" "\\1f\\2" text "${text}")
string(REPLACE "\n\n" ";" blocks "${text}")
list(TRANSFORM blocks STRIP)
list(TRANSFORM blocks REPLACE "\n" ",\n")
list(GET blocks 0 core_beckmann)
list(GET blocks 1 core_ggx)
list(GET blocks 2 vectors_beckmann)
list(GET blocks 3 vectors_ggx)
file(WRITE ${OUTPUT} "/* Generated from presets/rough_plastic.txt by cmake/embed_rough_plastic.cmake: do not edit. */
enum { TABLE_ALPHA = 32, TABLE_ETA = 11, TABLE_RANK = 18, TABLE_MU = 64 };
static const float table_core[2][TABLE_ALPHA * TABLE_ETA * TABLE_RANK] = {{
${core_beckmann}}, {
${core_ggx}}};
static const float table_vectors[2][TABLE_RANK * (TABLE_MU + 1)] = {{
${vectors_beckmann}}, {
${vectors_ggx}}};
")
