/* EGL without a surface: a hardware device, Mesa's surfaceless platform, or the software device. libEGL is
 * opened by name and stays loaded, as drivers keep threads and exit handlers. Displays are counted, because
 * EGL hands out the same display for the same question and one eglTerminate would end every context on it. */

#define EGL_NO_PLATFORM_SPECIFIC_TYPES
#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <pthread.h>
#include <stdio.h>
#include <string.h>

#include "runtime/gpu/context.h"

#define KD_EGL_LIST(X)                                                                                       \
    X(eglBindAPI, PFNEGLBINDAPIPROC)                                                                         \
    X(eglChooseConfig, PFNEGLCHOOSECONFIGPROC)                                                               \
    X(eglCreateContext, PFNEGLCREATECONTEXTPROC)                                                             \
    X(eglDestroyContext, PFNEGLDESTROYCONTEXTPROC)                                                           \
    X(eglGetError, PFNEGLGETERRORPROC)                                                                       \
    X(eglGetProcAddress, PFNEGLGETPROCADDRESSPROC)                                                           \
    X(eglInitialize, PFNEGLINITIALIZEPROC)                                                                   \
    X(eglMakeCurrent, PFNEGLMAKECURRENTPROC)                                                                 \
    X(eglQueryString, PFNEGLQUERYSTRINGPROC)                                                                 \
    X(eglTerminate, PFNEGLTERMINATEPROC)

enum { MAX_DEVICES = 16, MAX_DISPLAYS = 16 };

static struct egl_table {
#define EGL_MEMBER(name, type) type name;
    KD_EGL_LIST(EGL_MEMBER)
#undef EGL_MEMBER
    PFNEGLGETPLATFORMDISPLAYEXTPROC get_platform_display;
    PFNEGLQUERYDEVICESEXTPROC query_devices;            /* may be NULL */
    PFNEGLQUERYDEVICESTRINGEXTPROC query_device_string; /* may be NULL */
} egl;

static const gpu_symbol egl_symbols[] = {
#define EGL_SYMBOL(name, type) {#name, offsetof(struct egl_table, name)},
    KD_EGL_LIST(EGL_SYMBOL)
#undef EGL_SYMBOL
};

static pthread_mutex_t egl_lock = PTHREAD_MUTEX_INITIALIZER;
static void *egl_library;
static struct {
    EGLDisplay display;
    int users;
} egl_displays[MAX_DISPLAYS];

static bool has_extension(const char *list, const char *name)
{
    size_t length = strlen(name);
    for (const char *at = list; at && (at = strstr(at, name)); at += length)
        if ((at == list || at[-1] == ' ') && (at[length] == ' ' || at[length] == '\0'))
            return true;
    return false;
}

static const char *error_text(EGLint error)
{
    switch (error) {
    case EGL_NOT_INITIALIZED: return "EGL_NOT_INITIALIZED";
    case EGL_BAD_ALLOC: return "EGL_BAD_ALLOC";
    case EGL_BAD_ATTRIBUTE: return "EGL_BAD_ATTRIBUTE";
    case EGL_BAD_CONFIG: return "EGL_BAD_CONFIG";
    case EGL_BAD_MATCH: return "EGL_BAD_MATCH";
    case EGL_BAD_PARAMETER: return "EGL_BAD_PARAMETER";
    case EGL_BAD_ACCESS: return "EGL_BAD_ACCESS";
    case EGL_SUCCESS: return "no reason given";
    default: return "an unknown EGL error";
    }
}

static bool fail(gpu_reason *reason, const char *what)
{
    snprintf(reason->text, sizeof reason->text, "%s (%s)", what, error_text(egl.eglGetError()));
    return false;
}

static bool load_library(gpu_reason *reason)
{
    static const char *const names[] = {"libEGL.so.1", "libEGL.so", NULL};
    if (egl_library)
        return true;
    void *library = gpu_library_open(names, reason);
    if (!library ||
        !gpu_library_load(library, egl_symbols, sizeof egl_symbols / sizeof egl_symbols[0], &egl, reason))
        return false;
    egl.get_platform_display =
        (PFNEGLGETPLATFORMDISPLAYEXTPROC)egl.eglGetProcAddress("eglGetPlatformDisplayEXT");
    egl.query_devices = (PFNEGLQUERYDEVICESEXTPROC)egl.eglGetProcAddress("eglQueryDevicesEXT");
    egl.query_device_string =
        (PFNEGLQUERYDEVICESTRINGEXTPROC)egl.eglGetProcAddress("eglQueryDeviceStringEXT");
    if (!egl.get_platform_display) {
        snprintf(reason->text, sizeof reason->text, "libEGL lacks EGL_EXT_platform_base");
        return false;
    }
    egl_library = library;
    return true;
}

static bool retain_display(EGLDisplay display, gpu_reason *reason)
{
    int free_slot = -1;
    for (int i = 0; i < MAX_DISPLAYS; i++) {
        if (egl_displays[i].users && egl_displays[i].display == display) {
            egl_displays[i].users++;
            return true;
        }
        if (!egl_displays[i].users)
            free_slot = i;
    }
    if (free_slot < 0) {
        snprintf(reason->text, sizeof reason->text, "too many EGL displays are open");
        return false;
    }
    if (!egl.eglInitialize(display, NULL, NULL))
        return fail(reason, "the display cannot be initialised");
    egl_displays[free_slot].display = display;
    egl_displays[free_slot].users = 1;
    return true;
}

/* A leak checker can tell what a driver keeps for good from what was lost only while the driver is loaded,
 * and ending the display unloads it. */
#if defined(__SANITIZE_ADDRESS__)
enum { KEEP_DISPLAYS = 1 };
#else
enum { KEEP_DISPLAYS = 0 };
#endif

static void release_display(EGLDisplay display)
{
    for (int i = 0; i < MAX_DISPLAYS; i++)
        if (egl_displays[i].users && egl_displays[i].display == display && --egl_displays[i].users == 0 &&
            !KEEP_DISPLAYS)
            egl.eglTerminate(display);
}

static bool make_current_egl(gpu_context *context, bool on)
{
    return egl.eglMakeCurrent(context->display, EGL_NO_SURFACE, EGL_NO_SURFACE,
                              on ? context->handle : EGL_NO_CONTEXT) == EGL_TRUE;
}

static void close_egl(gpu_context *context)
{
    pthread_mutex_lock(&egl_lock);
    egl.eglMakeCurrent(context->display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    egl.eglDestroyContext(context->display, context->handle);
    release_display(context->display);
    pthread_mutex_unlock(&egl_lock);
}

static bool pick_config(EGLDisplay display, EGLConfig *config)
{
    *config = EGL_NO_CONFIG_KHR;
    if (has_extension(egl.eglQueryString(display, EGL_EXTENSIONS), "EGL_KHR_no_config_context"))
        return true;
    const EGLint wanted[] = {EGL_SURFACE_TYPE, 0, EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT, EGL_NONE};
    EGLint count = 0;
    return egl.eglChooseConfig(display, wanted, config, 1, &count) && count > 0;
}

static bool make_context(EGLDisplay display, bool debug, gpu_context *out, gpu_reason *reason)
{
    const EGLint attributes[] = {EGL_CONTEXT_MAJOR_VERSION,
                                 4,
                                 EGL_CONTEXT_MINOR_VERSION,
                                 5,
                                 EGL_CONTEXT_OPENGL_PROFILE_MASK,
                                 EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                                 EGL_CONTEXT_OPENGL_DEBUG,
                                 debug ? EGL_TRUE : EGL_FALSE,
                                 EGL_NONE};
    EGLConfig config;
    if (!has_extension(egl.eglQueryString(display, EGL_EXTENSIONS), "EGL_KHR_surfaceless_context")) {
        snprintf(reason->text, sizeof reason->text, "the driver lacks EGL_KHR_surfaceless_context");
        return false;
    }
    if (!egl.eglBindAPI(EGL_OPENGL_API) || !pick_config(display, &config))
        return fail(reason, "the driver offers no desktop OpenGL");
    EGLContext context = egl.eglCreateContext(display, config, EGL_NO_CONTEXT, attributes);
    if (context == EGL_NO_CONTEXT)
        return fail(reason, "no OpenGL 4.5 core context");
    if (!egl.eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, context)) {
        fail(reason, "the context cannot be made current");
        egl.eglDestroyContext(display, context);
        return false;
    }
    out->display = display;
    out->handle = context;
    return true;
}

static bool open_display(EGLenum platform, void *native, bool debug, gpu_context *out, gpu_reason *reason)
{
    EGLDisplay display = egl.get_platform_display(platform, native, NULL);
    if (display == EGL_NO_DISPLAY)
        return fail(reason, "the platform has no display");
    if (!retain_display(display, reason))
        return false;
    if (make_context(display, debug, out, reason))
        return true;
    release_display(display);
    return false;
}

static bool open_device(bool software, bool debug, gpu_context *out, gpu_reason *reason)
{
    EGLDeviceEXT devices[MAX_DEVICES];
    EGLint count = 0;
    if (!egl.query_devices || !egl.query_device_string) {
        snprintf(reason->text, sizeof reason->text, "libEGL lacks EGL_EXT_device_enumeration");
        return false;
    }
    if (!egl.query_devices(MAX_DEVICES, devices, &count))
        return fail(reason, "devices cannot be listed");
    snprintf(reason->text, sizeof reason->text, "no %s device among %d", software ? "software" : "hardware",
             (int)count);
    for (EGLint i = 0; i < count; i++) {
        const char *extensions = egl.query_device_string(devices[i], EGL_EXTENSIONS);
        if (has_extension(extensions, "EGL_MESA_device_software") == software &&
            open_display(EGL_PLATFORM_DEVICE_EXT, devices[i], debug, out, reason))
            return true;
    }
    return false;
}

static bool open_surfaceless(bool debug, gpu_context *out, gpu_reason *reason)
{
    if (!has_extension(egl.eglQueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS), "EGL_MESA_platform_surfaceless")) {
        snprintf(reason->text, sizeof reason->text, "libEGL lacks EGL_MESA_platform_surfaceless");
        return false;
    }
    return open_display(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, debug, out, reason);
}

bool gpu_context_open_egl(const kd_gpu_desc *desc, kd_context_api api, gpu_context *out, gpu_reason *reason)
{
    pthread_mutex_lock(&egl_lock);
    bool opened =
        load_library(reason) && (api == KD_CONTEXT_EGL_SURFACELESS
                                     ? open_surfaceless(desc->debug, out, reason)
                                     : open_device(api == KD_CONTEXT_EGL_SOFTWARE, desc->debug, out, reason));
    if (opened) {
        out->api = api;
        out->hardware_only = api == KD_CONTEXT_EGL_DEVICE;
        out->lookup = egl.eglGetProcAddress;
        out->make_current = make_current_egl;
        out->close = close_egl;
    }
    pthread_mutex_unlock(&egl_lock);
    return opened;
}
