#include "runtime/app/extension.h"

int main(int argc, char **argv)
{
    return kd_main(argc, argv, NULL);
}
