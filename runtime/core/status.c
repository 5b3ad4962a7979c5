#include "runtime/core/status.h"

const char *kd_status_text(kd_status status)
{
    static const char *const texts[] = {
#define STATUS_TEXT(name, text) [KD_##name] = text,
        KD_STATUS_LIST(STATUS_TEXT)
#undef STATUS_TEXT
    };
    return (unsigned)status < KD_STATUS_COUNT ? texts[status] : "unknown status";
}
