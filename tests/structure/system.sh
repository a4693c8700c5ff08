#!/bin/sh
# SPDX-License-Identifier: MIT
# What ISO C does not have is called through src/base/os.h, which is implemented once for each system (src/base/os_*.c). Other files
# include headers of ISO C, of OpenMP, of vectors of the processor, and of libraries; and their objects take none of these functions
# of POSIX, nor those of ISO C to which a path is given, which is UTF-8 on every system.
set -eu
build=${NQM_BUILD:?}
cd "${NQM_SOURCE:-$(dirname "$0")/../..}"
bad=0

# Files of the tool that still use POSIX for the terminal, signals, child processes and limits; and the program of benchmarks.
todo='tools/nqm/(main|talk|conform/cmd_conform|machine/cmd_doctor)\.c|tools/bench/[a-z_]*\.c'
iso='assert|complex|ctype|errno|fenv|float|inttypes|iso646|limits|locale|math|setjmp|signal|stdalign|stdarg|stdatomic|stdbool|stddef|stdint|stdio|stdlib|stdnoreturn|string|tgmath|time|uchar|wchar|wctype'
libraries='nqm/[a-z]*|cminpack|embree[34]/rtcore|expat|jansson|jerror|jpeglib|openexr|openssl/evp|png|webp/decode|zip|zlib'
grep -rnE '^[[:space:]]*#[[:space:]]*include[[:space:]]*<' src tools --include='*.[ch]' >"$build/system.txt"
[ "$(wc -l <"$build/system.txt")" -gt 400 ] || { echo "hardly any include was found: the test is broken"; bad=1; }
if grep -vE "^(src/base/os(_[a-z]*\.c|\.h)|$todo):|<($iso|$libraries|omp|immintrin|arm_neon)\.h>" "$build/system.txt"; then
    echo "only src/base/os.h and its implementations include headers of a system"
    bad=1
fi

posix='accept|access|asprintf|basename|chdir|chmod|clock_gettime|close|closedir|dirname|dlopen|dlsym|dup2?|exec[lv][pe]*|fchmod|fcntl|fdopen|fileno|flock|fmemopen|fork|fopen|freopen|fseeko|f?l?stat|fsync|ftello|fts_open|ftruncate|getcwd|getline|getpid|gmtime_r|isatty|kill|localtime_r|madvise|memmem|mk[ds]t[a-z]*|mkdir|mmap|munmap|nanosleep|newlocale|nftw|open|open_memstream|openat|opendir|pclose|poll|popen|posix_[a-z_]*|preadv?2?|pthread_atfork|pwrite|read|readdir|realpath|remove|rename|rmdir|scandir|sigaction|sleep|str[cn]*casecmp|strcasestr|strsep|strtok_r|sysconf|tmpfile|unlink|uselocale|usleep|waitpid|write'
objects=$(grep -o 'CMakeFiles/nqm[^ ]*\.dir/\(src\|tools\)/[^ ]*\.o' "$build/compile_commands.json" | sort -u)
# shellcheck disable=SC2086
(cd "$build" && nm -A --undefined-only $objects) | sed 's|^CMakeFiles/[^/]*\.dir/||; s|\.o: *U |: |' >"$build/system.txt"
[ "$(wc -l <"$build/system.txt")" -gt 1000 ] || { echo "hardly any symbol was found: the test is broken"; bad=1; }
if grep -E ": ($posix)(64)?(@.*)?\$" "$build/system.txt" | grep -vE "^(src/base/os_[a-z]*\.c|$todo):"; then
    echo "only the implementations of src/base/os.h call these functions"
    bad=1
fi
exit $bad
