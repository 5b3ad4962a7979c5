/* Linked into every executable of a sanitizer build: the options it needs with OpenGL drivers, and what of
 * theirs is not ours to mend. Nothing of the project itself may be listed here. */

const char *__asan_default_options(void);
const char *__lsan_default_suppressions(void);
const char *__ubsan_default_options(void);
const char *__tsan_default_options(void);
const char *__tsan_default_suppressions(void);
int dlclose(void *library);

/* Mesa's drivers are loaded late and keep thread-local data. gcc 12's bookkeeping of it is wrong once such a
 * thread has ended, and the search for leaks then stumbles over freed memory. */
const char *__asan_default_options(void)
{
    return "intercept_tls_get_addr=0:print_suppressions=0:strict_string_checks=1:detect_stack_use_after_"
           "return=1";
}

/* Display stacks keep tables for the life of the process and lose them when they are unloaded; tinyexr loses
 * the header, or lists of pixels, of files whose pixels are damaged. */
const char *__lsan_default_suppressions(void)
{
    return "leak:libOSMesa.so\n"   /* the framebuffer's record of its last context */
           "leak:libGLX_mesa.so\n" /* configurations, screens */
           "leak:libglapi.so\n"
           "leak:swrast_dri.so\n" /* driver options, by name */
           "leak:libtinyexr.so\n"
           "leak:libX11.so\n" /* extension and locale tables */
           "leak:libglfw.so\n";
}

const char *__ubsan_default_options(void)
{
    return "print_stacktrace=1:halt_on_error=1";
}

const char *__tsan_default_options(void)
{
    return "second_deadlock_stack=1:history_size=4:print_suppressions=0";
}

/* llvmpipe destroys a fence once a worker has signalled it, while that worker may still be letting go of the
 * fence's lock. Told apart by what is on top, so that everything else a driver does with our memory counts.
 */
const char *__tsan_default_suppressions(void)
{
    return "race_top:pthread_mutex_destroy\n"
           "race_top:pthread_cond_destroy\n";
}

/* Libraries stay loaded, so that a report at the end can name the one it is about. */
int dlclose(void *library)
{
    (void)library;
    return 0;
}
