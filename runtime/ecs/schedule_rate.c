/* Rates. Nothing is accumulated: how often a fixed rate is due in a frame is how many multiples of its step
 * lie between the frame's beginning and its end. */
#include <assert.h>
#include <math.h>

#include "runtime/ecs/schedule_internal.h"

#define FIRST_STEP_S (1.0 / 60)
#define MAX_RUNS     8u
/* In steps: what rounding may take from a sum of frames that ends on a multiple. */
#define TOLERANCE 1e-6

static const kd_schedule_clock clock_default = {.step_s = FIRST_STEP_S};
KD_COMPONENT_DEFINE_DEFAULT(kd_schedule_clock, "schedule_clock", &clock_default,
                            KD_FIELD(kd_schedule_clock, frame, KD_U32, NULL, "frames run"));

void kd_schedule_set_step(kd_schedule *s, double step_s)
{
    assert(step_s >= 0);
    s->clock->step_s = step_s;
}

static double steps_until(double time_s, double every_s)
{
    return floor(time_s / every_s + TOLERANCE);
}

uint32_t schedule_due(const kd_schedule *s, const schedule_system *system, uint64_t *dropped)
{
    const kd_system_rate *rate = &system->desc.rate;
    const kd_schedule_clock *clock = s->clock;
    *dropped = 0;
    if (rate->every_s <= 0)
        return rate->every_frames < 2 || clock->frame % rate->every_frames == rate->offset_frames;
    double runs =
        steps_until(clock->time_s + clock->step_s, rate->every_s) - steps_until(clock->time_s, rate->every_s);
    uint32_t most = rate->max_runs ? rate->max_runs : MAX_RUNS;
    if (runs <= most)
        return (uint32_t)runs;
    *dropped = (uint64_t)(runs - most);
    return most;
}

void schedule_set_time(const kd_schedule *s, const schedule_system *system, uint32_t left,
                       kd_system_context *context)
{
    const kd_system_rate *rate = &system->desc.rate;
    const kd_schedule_clock *clock = s->clock;
    context->frame = clock->frame;
    context->time_s = clock->time_s;
    context->dt_s = clock->step_s * (rate->every_frames > 1 ? rate->every_frames : 1);
    if (rate->every_s > 0) {
        context->time_s = (steps_until(clock->time_s + clock->step_s, rate->every_s) - left) * rate->every_s;
        context->dt_s = rate->every_s;
    }
}

void schedule_clock_advance(kd_schedule *s)
{
    s->clock->time_s += s->clock->step_s;
    s->clock->frame++;
}
