#ifndef KD_GPU_WINDOW_H
#define KD_GPU_WINDOW_H

/* What happens to the window of a GLFW context. Events wait in a ring until they are taken; lengths and
 * positions are pixels of the window's picture, (0, 0) at its upper left. Threading: the main thread. */

#include "runtime/gpu/gpu.h"

/* KEY(name, number, text): keys by their place on a US keyboard. The numbers are GLFW's. */
/* clang-format off */
#define KD_KEY_LIST(KEY)                                                                                    \
    KEY(SPACE, 32, "space") KEY(APOSTROPHE, 39, "'") KEY(COMMA, 44, ",") KEY(MINUS, 45, "-")                \
    KEY(PERIOD, 46, ".") KEY(SLASH, 47, "/") KEY(0, 48, "0") KEY(1, 49, "1") KEY(2, 50, "2")                \
    KEY(3, 51, "3") KEY(4, 52, "4") KEY(5, 53, "5") KEY(6, 54, "6") KEY(7, 55, "7") KEY(8, 56, "8")         \
    KEY(9, 57, "9") KEY(SEMICOLON, 59, ";") KEY(EQUAL, 61, "=") KEY(A, 65, "a") KEY(B, 66, "b")             \
    KEY(C, 67, "c") KEY(D, 68, "d") KEY(E, 69, "e") KEY(F, 70, "f") KEY(G, 71, "g") KEY(H, 72, "h")         \
    KEY(I, 73, "i") KEY(J, 74, "j") KEY(K, 75, "k") KEY(L, 76, "l") KEY(M, 77, "m") KEY(N, 78, "n")         \
    KEY(O, 79, "o") KEY(P, 80, "p") KEY(Q, 81, "q") KEY(R, 82, "r") KEY(S, 83, "s") KEY(T, 84, "t")         \
    KEY(U, 85, "u") KEY(V, 86, "v") KEY(W, 87, "w") KEY(X, 88, "x") KEY(Y, 89, "y") KEY(Z, 90, "z")         \
    KEY(LEFT_BRACKET, 91, "[") KEY(BACKSLASH, 92, "\\") KEY(RIGHT_BRACKET, 93, "]") KEY(GRAVE, 96, "`")     \
    KEY(ESCAPE, 256, "escape") KEY(ENTER, 257, "enter") KEY(TAB, 258, "tab")                                \
    KEY(BACKSPACE, 259, "backspace") KEY(INSERT, 260, "insert") KEY(DELETE, 261, "delete")                  \
    KEY(RIGHT, 262, "right") KEY(LEFT, 263, "left") KEY(DOWN, 264, "down") KEY(UP, 265, "up")               \
    KEY(PAGE_UP, 266, "page_up") KEY(PAGE_DOWN, 267, "page_down") KEY(HOME, 268, "home")                    \
    KEY(END, 269, "end") KEY(F1, 290, "f1") KEY(F2, 291, "f2") KEY(F3, 292, "f3") KEY(F4, 293, "f4")        \
    KEY(F5, 294, "f5") KEY(F6, 295, "f6") KEY(F7, 296, "f7") KEY(F8, 297, "f8") KEY(F9, 298, "f9")          \
    KEY(F10, 299, "f10") KEY(F11, 300, "f11") KEY(F12, 301, "f12") KEY(KP_0, 320, "kp_0")                   \
    KEY(KP_1, 321, "kp_1") KEY(KP_2, 322, "kp_2") KEY(KP_3, 323, "kp_3") KEY(KP_4, 324, "kp_4")             \
    KEY(KP_5, 325, "kp_5") KEY(KP_6, 326, "kp_6") KEY(KP_7, 327, "kp_7") KEY(KP_8, 328, "kp_8")             \
    KEY(KP_9, 329, "kp_9") KEY(KP_DECIMAL, 330, "kp_decimal") KEY(KP_DIVIDE, 331, "kp_divide")              \
    KEY(KP_MULTIPLY, 332, "kp_multiply") KEY(KP_SUBTRACT, 333, "kp_subtract") KEY(KP_ADD, 334, "kp_add")    \
    KEY(KP_ENTER, 335, "kp_enter") KEY(LEFT_SHIFT, 340, "left_shift")                                       \
    KEY(LEFT_CONTROL, 341, "left_control") KEY(LEFT_ALT, 342, "left_alt")                                   \
    KEY(RIGHT_SHIFT, 344, "right_shift") KEY(RIGHT_CONTROL, 345, "right_control")                           \
    KEY(RIGHT_ALT, 346, "right_alt")
/* clang-format on */

typedef enum kd_key {
    KD_KEY_NONE = -1,
#define KD_KEY_ENUM(name, number, text) KD_KEY_##name = (number),
    KD_KEY_LIST(KD_KEY_ENUM)
#undef KD_KEY_ENUM
        KD_KEY_COUNT = 349
} kd_key;

/** Get the name of a key: "a", "space", "kp_5". Returns NULL for one without. */
const char *kd_key_name(int key);
/** Find a key by its name. Returns KD_KEY_NONE when there is none. */
int kd_key_find(const char *name);

typedef enum kd_mouse_button {
    KD_MOUSE_LEFT,
    KD_MOUSE_RIGHT,
    KD_MOUSE_MIDDLE,
    KD_MOUSE_COUNT
} kd_mouse_button;

typedef enum kd_window_event_kind {
    KD_WINDOW_KEY,     /* code: kd_key, down, repeat */
    KD_WINDOW_TEXT,    /* code: a character, UTF-32 */
    KD_WINDOW_BUTTON,  /* code: kd_mouse_button, down, x, y */
    KD_WINDOW_POINTER, /* x, y */
    KD_WINDOW_SCROLL,  /* x, y: notches; y > 0 away from the hand */
    KD_WINDOW_FOCUS,   /* down: gained */
    KD_WINDOW_LEFT,    /* the pointer left the window */
    KD_WINDOW_CHANGED, /* another size, another scale, uncovered: its picture is to be drawn anew */
} kd_window_event_kind;

typedef enum kd_modifier { KD_MOD_SHIFT = 1, KD_MOD_CONTROL = 2, KD_MOD_ALT = 4 } kd_modifier;

typedef struct kd_window_event {
    kd_window_event_kind kind;
    int code;
    bool down, repeat;
    uint32_t modifiers; /* kd_modifier bits */
    float x, y;
} kd_window_event;

/** Wait until something happens, or for that long; 0: look and go on. */
void kd_gpu_window_wait(kd_gpu *gpu, double seconds);
/** Take the oldest event. Returns false when there is none. */
bool kd_gpu_window_event(kd_gpu *gpu, kd_window_event *out);
/** Tell whether it was asked to close, without looking for events. */
bool kd_gpu_window_closing(kd_gpu *gpu);
/** Ask it to close. */
void kd_gpu_window_close(kd_gpu *gpu);
/** How much larger than on a plain monitor text is to be: 1, 1.5, 2 … */
float kd_gpu_window_scale(kd_gpu *gpu);
bool kd_gpu_window_minimized(kd_gpu *gpu);
void kd_gpu_window_title(kd_gpu *gpu, const char *title);
/** Give the window a size, of its picture. */
void kd_gpu_window_resize(kd_gpu *gpu, uint32_t width, uint32_t height);

#endif
