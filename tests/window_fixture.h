/* Uses the window of the program as a person does: an X server of the test's own, keys and mouse pressed
 * through its test extension, pictures taken from its screen. Included once, by the test's only source. */
#ifndef KD_TESTS_WINDOW_FIXTURE_H
#define KD_TESTS_WINDOW_FIXTURE_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <dlfcn.h>

#include "tests/program_fixture.h"
#include "tests/xvfb_fixture.h"

enum {
    WINDOW_SKIP = 77,
    WINDOW_WIDTH = 480,
    WINDOW_HEIGHT = 240,
    WINDOW_PIXELS = WINDOW_WIDTH * WINDOW_HEIGHT
};

/* How long something may take at most: a limit for a program that hangs, no measure. */
#define WINDOW_PATIENCE_S (PROGRAM_LIMIT_S * 6)

/* ---- the parts of Xlib and XTest that are used ---- */

typedef unsigned long x_id;
typedef struct x_image { /* the beginning of XImage */
    int width, height, xoffset, format;
    char *data;
    int byte_order, bitmap_unit, bitmap_bit_order, bitmap_pad, depth, bytes_per_line, bits_per_pixel;
} x_image;

static struct {
    void *display;
    void *(*open)(const char *name);
    int (*close)(void *display);
    x_id (*root)(void *display);
    int (*tree)(void *display, x_id window, x_id *root, x_id *parent, x_id **children, unsigned *count);
    int (*focus)(void *display, x_id window, int revert_to, unsigned long time);
    int (*map)(void *display, x_id window);
    int (*unmap)(void *display, x_id window);
    int (*change_property)(void *display, x_id window, unsigned long property, unsigned long type, int bits,
                           int mode, const unsigned char *data, int count);
    int (*resize)(void *display, x_id window, unsigned width, unsigned height);
    x_image *(*image)(void *display, x_id window, int x, int y, unsigned width, unsigned height,
                      unsigned long planes, int format);
    int (*destroy)(void *thing); /* XFree */
    int (*sync)(void *display, int discard);
    unsigned char (*key_code)(void *display, unsigned long symbol);
    int (*key)(void *display, unsigned code, int down, unsigned long delay);
    int (*button)(void *display, unsigned button, int down, unsigned long delay);
    int (*move)(void *display, int screen, int x, int y, unsigned long delay);
} x;

static bool window_load(void *library, const char *name, void *function)
{
    void *address = library ? dlsym(library, name) : NULL;
    memcpy(function, &address, sizeof address);
    return address != NULL;
}

/* Returns false when something that is needed is missing. */
static bool window_open_x(void)
{
    void *xlib = dlopen("libX11.so.6", RTLD_NOW), *test = dlopen("libXtst.so.6", RTLD_NOW);
    bool good = window_load(xlib, "XOpenDisplay", &x.open) && window_load(xlib, "XCloseDisplay", &x.close) &&
                window_load(xlib, "XDefaultRootWindow", &x.root) &&
                window_load(xlib, "XSetInputFocus", &x.focus) && window_load(xlib, "XMapWindow", &x.map) &&
                window_load(xlib, "XUnmapWindow", &x.unmap) &&
                window_load(xlib, "XChangeProperty", &x.change_property) &&
                window_load(xlib, "XQueryTree", &x.tree) && window_load(xlib, "XResizeWindow", &x.resize) &&
                window_load(xlib, "XGetImage", &x.image) && window_load(xlib, "XFree", &x.destroy) &&
                window_load(xlib, "XSync", &x.sync) && window_load(xlib, "XKeysymToKeycode", &x.key_code) &&
                window_load(test, "XTestFakeKeyEvent", &x.key) &&
                window_load(test, "XTestFakeButtonEvent", &x.button) &&
                window_load(test, "XTestFakeMotionEvent", &x.move);
    if (good)
        x.display = x.open(NULL);
    return good && x.display;
}

/* ---- keys and mouse ---- */

/* Numbers of X's keysymdef.h. */
enum {
    KEY_CONTROL = 0xffe3,
    KEY_F1 = 0xffbe,
    KEY_F2,
    KEY_F5 = KEY_F1 + 4,
    KEY_F6,
    KEY_F7,
    KEY_F12 = KEY_F1 + 11,
    KEY_KP_ADD = 0xffab,
    KEY_KP_2 = 0xff99, /* KP_Down: the keys of the pad without Num Lock */
    KEY_KP_5 = 0xff9d,
};

static void window_hold(unsigned long symbol, bool down)
{
    x.key(x.display, x.key_code(x.display, symbol), down, 0);
    x.sync(x.display, 0);
}

static void window_key(unsigned long symbol)
{
    window_hold(symbol, true);
    window_hold(symbol, false);
    /* GLFW takes what follows at once for a key that repeats. */
    nanosleep(&(struct timespec){.tv_nsec = 60000000}, NULL);
}

static inline void window_control(unsigned long symbol)
{
    window_hold(KEY_CONTROL, true);
    window_key(symbol);
    window_hold(KEY_CONTROL, false);
}

static void window_move(int to_x, int to_y)
{
    x.move(x.display, -1, to_x, to_y, 0);
    x.sync(x.display, 0);
}

static inline void window_drag(unsigned button, int from_x, int from_y, int to_x, int to_y)
{
    window_move(from_x, from_y);
    x.button(x.display, button, 1, 0);
    for (int i = 1; i <= 4; i++)
        window_move(from_x + (to_x - from_x) * i / 4, from_y + (to_y - from_y) * i / 4);
    x.button(x.display, button, 0, 0);
    x.sync(x.display, 0);
}

/* ---- the program ---- */

static program window_program;
static char window_folder[64];

static int window_setup(void **state)
{
    (void)state;
    snprintf(window_folder, sizeof window_folder, "/tmp/kandil_window_XXXXXX");
    return mkdtemp(window_folder) && chdir(window_folder) == 0 ? 0 : -1;
}

static int window_teardown(void **state)
{
    char command[96];
    (void)state;
    if (window_program.pid > 0) { /* a check has failed */
        kill(window_program.pid, SIGKILL);
        waitpid(window_program.pid, NULL, 0);
        window_program.pid = 0;
    }
    if (getenv("KD_KEEP_PICTURES"))
        return chdir("/");
    snprintf(command, sizeof command, "rm -rf '%s'", window_folder);
    return chdir("/") == 0 && system(command) == 0 ? 0 : -1;
}

/* Write a file of the test's folder, in one go: what watches it sees it whole. */
static void window_write(const char *name, const char *text)
{
    char temp[128];
    snprintf(temp, sizeof temp, "%s.part", name);
    FILE *file = fopen(temp, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(text, 1, strlen(text), file), strlen(text));
    assert_int_equal(fclose(file), 0);
    assert_int_equal(rename(temp, name), 0);
}

static void window_start(const char *scene)
{
    const char *const argv[] = {PROGRAM_PATH, "run", scene, "--window", "--threads", "1", NULL};
    assert_true(program_start(&window_program, "said.txt", argv, WINDOW_PATIENCE_S * 4));
    window_move(WINDOW_WIDTH / 2, WINDOW_HEIGHT / 2); /* keys go to the window under the pointer */
}

/* Close the window as a person does. Returns what the program said. */
static const char *window_finish(void)
{
    window_control('q');
    program_wait(&window_program);
    assert_false(window_program.timed_out);
    assert_int_equal(window_program.code, 0);
    return window_program.said;
}

/* How often the program has said something so far. */
static inline int window_times_said(const char *text)
{
    char said[8192];
    FILE *file = fopen("said.txt", "rb");
    size_t size = file ? fread(said, 1, sizeof said - 1, file) : 0;
    int count = 0;
    said[size] = '\0';
    if (file)
        fclose(file);
    for (const char *p = said; (p = strstr(p, text)) != NULL; p++)
        count++;
    return count;
}

static inline bool window_said(const char *text)
{
    return window_times_said(text) > 0;
}

/* ---- pictures ---- */

typedef struct picture {
    uint8_t rgb[WINDOW_PIXELS][3];
} picture;

static void window_see(picture *out)
{
    x_image *image = x.image(x.display, x.root(x.display), 0, 0, WINDOW_WIDTH, WINDOW_HEIGHT, ~0ul, 2);
    assert_non_null(image);
    assert_int_equal(image->bits_per_pixel, 32);
    for (int i = 0; i < WINDOW_PIXELS; i++) {
        const uint8_t *bgrx = (const uint8_t *)image->data +
                              (size_t)(i / WINDOW_WIDTH * image->bytes_per_line) +
                              (size_t)(i % WINDOW_WIDTH) * 4;
        for (int k = 0; k < 3; k++)
            out->rgb[i][k] = bgrx[2 - k];
    }
    x.destroy(image->data);
    x.destroy(image);
}

typedef struct area {
    int left, top, right, bottom;
} area;

static const area whole = {0, 0, WINDOW_WIDTH, WINDOW_HEIGHT};

/* Mean of a channel, 0 to 255; channel 3: of all. */
static double picture_mean(const picture *p, area a, int channel)
{
    double sum = 0;
    for (int row = a.top; row < a.bottom; row++)
        for (int column = a.left; column < a.right; column++) {
            const uint8_t *rgb = p->rgb[row * WINDOW_WIDTH + column];
            sum += channel < 3 ? rgb[channel] : (rgb[0] + rgb[1] + rgb[2]) / 3.0;
        }
    return sum / ((a.right - a.left) * (a.bottom - a.top));
}

/* Mean difference, 0 to 255. */
static double picture_difference(const picture *a, const picture *b)
{
    double sum = 0;
    for (int i = 0; i < WINDOW_PIXELS * 3; i++)
        sum += abs((int)(&a->rgb[0][0])[i] - (int)(&b->rgb[0][0])[i]);
    return sum / (WINDOW_PIXELS * 3);
}

static void window_rest(double seconds)
{
    nanosleep(&(struct timespec){.tv_sec = (time_t)seconds,
                                 .tv_nsec = (long)((seconds - (double)(time_t)seconds) * 1e9)},
              NULL);
}

/* What was seen goes to a file when KD_KEEP_PICTURES is set: then someone wants to look at it. */
static void window_fail(const picture *p, int line, const char *what)
{
    FILE *file = getenv("KD_KEEP_PICTURES") ? fopen("seen.ppm", "wb") : NULL;
    if (file) {
        fprintf(file, "P6\n%d %d\n255\n", WINDOW_WIDTH, WINDOW_HEIGHT);
        fwrite(p->rgb, 1, sizeof p->rgb, file);
        fclose(file);
    }
    fail_msg("line %d: never came: %s", line, what);
}

/* Look until the condition on `seen` holds; the test fails when that takes too long. */
#define WINDOW_UNTIL(seen, condition)                                                                        \
    do {                                                                                                     \
        double deadline_ = program_clock_s() + WINDOW_PATIENCE_S;                                            \
        for (;;) {                                                                                           \
            window_see(seen);                                                                                \
            if (condition)                                                                                   \
                break;                                                                                       \
            if (program_clock_s() > deadline_)                                                               \
                window_fail(seen, __LINE__, #condition);                                                     \
            window_rest(0.02);                                                                               \
        }                                                                                                    \
    } while (0)

/* Wait until the picture stands still: equal for a while. */
static inline void window_settle(picture *out)
{
    static picture last;
    int equal = 0;
    window_see(&last);
    for (double deadline = program_clock_s() + WINDOW_PATIENCE_S; equal < 15;) {
        window_rest(0.02);
        window_see(out);
        equal = picture_difference(out, &last) == 0 ? equal + 1 : 0;
        last = *out;
        if (program_clock_s() > deadline)
            window_fail(out, __LINE__, "a picture that stands still");
    }
}

/* ---- running tests ---- */

#define WINDOW_TEST(name) cmocka_unit_test_setup_teardown(name, window_setup, window_teardown)

/* Run a group with an X server of its own. Returns the exit code of the program. */
#define WINDOW_RUN(tests)                                                                                    \
    (!dlopen("libglfw.so.3", RTLD_NOW) || !xvfb_start("800x600x24") || !window_open_x()                      \
         ? (fprintf(stderr, "skipped: Xvfb, libglfw.so.3, libX11.so.6 or libXtst.so.6 is missing\n"),        \
            xvfb_server > 0 ? xvfb_stop() : (void)0, WINDOW_SKIP)                                            \
         : window_end(cmocka_run_group_tests(tests, NULL, NULL)))

static inline int window_end(int failures)
{
    x.close(x.display);
    xvfb_stop();
    return failures;
}

#endif
