/* SPDX-License-Identifier: MIT
 *
 * png_colours FILE.png - print the number of colours of a picture, to 5 bits per channel, the percentage of white pixels, and
 * the number of white columns at its right edge, to detect blank pages and pages that do not fit the window.
 */
#include <png.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>

int main(int argc, char **argv) {
    enum { N_COLOURS = 1 << 15 };
    static unsigned char seen[N_COLOURS];
    png_image image = {.version = PNG_IMAGE_VERSION};
    if (argc != 2 || !png_image_begin_read_from_file(&image, argv[1]))
        return EXIT_FAILURE;
    image.format = PNG_FORMAT_RGB;
    unsigned char *rgb = malloc(PNG_IMAGE_SIZE(image));
    if (!rgb || !png_image_finish_read(&image, NULL, rgb, 0, NULL)) {
        free(rgb);
        return EXIT_FAILURE;
    }
    size_t n = (size_t)image.width * image.height, n_white = 0, n_colours = 0, n_reached = 0;
    for (size_t i = 0; i < n; ++i) {
        const unsigned char *p = rgb + 3 * i;
        int colour = (p[0] >> 3) << 10 | (p[1] >> 3) << 5 | p[2] >> 3;
        bool white = p[0] == 255 && p[1] == 255 && p[2] == 255;
        n_white += white;
        if (!white && i % image.width >= n_reached)
            n_reached = i % image.width + 1;
        n_colours += !seen[colour];
        seen[colour] = 1;
    }
    printf("%zu %zu %zu\n", n_colours, 100 * n_white / n, image.width - n_reached);
    free(rgb);
    return EXIT_SUCCESS;
}
