#include <dlfcn.h>

#include "context_use.h"

static void osmesa_context_is_used(void **state)
{
    (void)state;
    for (int i = 0; i < 2; i++) {
        kd_gpu *gpu = context_open(KD_CONTEXT_OSMESA, false);
        if (!gpu)
            fail_msg("%s", fixture_text);
        assert_string_equal(kd_gpu_get_info(gpu)->api, "osmesa");
        assert_true(kd_gpu_get_info(gpu)->software);
        context_use(gpu);
        kd_gpu_close(gpu);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {CONTEXT_TEST(osmesa_context_is_used)};
    if (!dlopen("libOSMesa.so.8", RTLD_NOW) && !dlopen("libOSMesa.so.6", RTLD_NOW)) {
        fprintf(stderr, "skipped: libOSMesa is missing\n");
        return FIXTURE_SKIP;
    }
    return cmocka_run_group_tests(tests, NULL, NULL);
}
