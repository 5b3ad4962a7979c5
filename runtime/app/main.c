#include "runtime/app/app.h"

int main(int argc, char **argv)
{
    return kd_app_main(argc, argv);
}
