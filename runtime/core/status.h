#ifndef KD_CORE_STATUS_H
#define KD_CORE_STATUS_H

/* Every way in which the environment can let a call down, once. Misuse asserts instead. */
#define KD_STATUS_LIST(X)                                                                                    \
    X(OK, "done")                                                                                            \
    X(NO_MEMORY, "out of memory")                                                                            \
    X(NOT_FOUND, "not found")                                                                                \
    X(NO_PERMISSION, "permission denied")                                                                    \
    X(IO, "reading or writing failed")                                                                       \
    X(DISK_FULL, "no space left on the disk")                                                                \
    X(BAD_FORMAT, "the data are malformed")                                                                  \
    X(UNSUPPORTED, "not supported")                                                                          \
    X(OUT_OF_RANGE, "a value is out of range")                                                               \
    X(TOO_LARGE, "larger than the limit")                                                                    \
    X(NO_CONTEXT, "no usable OpenGL context")                                                                \
    X(GPU, "the GPU or its driver refused")                                                                  \
    X(SCRIPT, "the scenario failed")                                                                         \
    X(USAGE, "the command line is wrong")                                                                    \
    X(INTERRUPTED, "interrupted")

typedef enum kd_status {
#define KD_STATUS_ENUM(name, text) KD_##name,
    KD_STATUS_LIST(KD_STATUS_ENUM)
#undef KD_STATUS_ENUM
        KD_STATUS_COUNT
} kd_status;

/** Name a status in words. Returns a static string, never NULL. */
const char *kd_status_text(kd_status status);

#endif
