/* SPDX-License-Identifier: MIT
 *
 * The file of temp_file.h.
 */
#include "support/temp_file.h"

#include <stdlib.h>
#include <unistd.h>

char temp_file[] = "/tmp/nqm-test-XXXXXX";

int make_temp_file(void **state) {
    (void)state;
    int fd = mkstemp(temp_file);
    return fd < 0 ? -1 : close(fd);
}

int remove_temp_file(void **state) {
    (void)state;
    return unlink(temp_file);
}
