# SPDX-License-Identifier: MIT
# cmake -DOUTPUT=file.h -DINPUT=metals.txt -P embed_metals.cmake: write each line "NAME: eta; k" as a C initialiser.
file(READ ${INPUT} text)
string(REGEX REPLACE "#[^\n]*\n" "" text "${text}")
string(REGEX REPLACE "([^:\n]+): ([^;\n]+); ([^\n]+)\n" "{\"\\1\", {\\2}, {\\3}},\n" text "${text}")
file(WRITE ${OUTPUT} "/* Generated from presets/metals.txt by cmake/embed_metals.cmake: do not edit. */\n${text}")
