/* Writes the models that the samples use: `kandil-assets FOLDER`. The same bytes on every machine; after a
 * change to this program its output is committed beside it. */

#include <stdio.h>

#include "samples/assets/generate.h"

int main(int argc, char **argv)
{
    if (argc != 2) {
        fputs("kandil-assets: one argument is needed: the folder to write the models into\n", stderr);
        return 2;
    }
    return cornell_write(argv[1]) && walker_write(argv[1]) && drop_write(argv[1]) ? 0 : 1;
}
