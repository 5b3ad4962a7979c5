#include "components/emitters.h"

#include "shaders/shared/bindings.h"
#include "shaders/shared/emitters.h"

KD_COMPONENT_DEFINE_FLAGS(kd_emitters, "emitters", KD_COMPONENT_TRANSIENT,
                          KD_FIELD(kd_emitters, some, KD_BOOL, NULL, "something glows"));

void kd_emitters_bind(kd_gpu *gpu, const kd_emitters *emitters)
{
    kd_gpu_bind_uniform_buffer(gpu, KD_BIND_EMITTERS, emitters->list, 0, sizeof(struct kd_emitters_params));
}
