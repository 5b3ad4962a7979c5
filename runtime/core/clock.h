#ifndef KD_CORE_CLOCK_H
#define KD_CORE_CLOCK_H

#include <stdint.h>

/** Read the monotonic clock.
 *
 *  Units      ns since an arbitrary moment
 *  Threading  any; the same clock on every thread
 *  Cost       about 25 ns
 */
uint64_t kd_clock_ns(void);

/** Read the processor time that the calling thread has used.
 *
 *  Units      ns since the thread began
 *  Threading  any; each thread has its own
 *  Cost       a system call, about 300 ns
 */
uint64_t kd_clock_thread_ns(void);

#endif
