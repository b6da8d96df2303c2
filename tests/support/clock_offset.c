/* Moves a process's wall clock by CLOCK_OFFSET_MS, for tests: a host whose clock is off.
   Built as a shared library and loaded by LD_PRELOAD. The monotonic clocks stay. */
#define _GNU_SOURCE
#include <stdlib.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

int clock_gettime(clockid_t id, struct timespec *now)
{
    long done = syscall(SYS_clock_gettime, id, now);
    const char *text = getenv("CLOCK_OFFSET_MS");
    if (done == 0 && text != NULL && (id == CLOCK_REALTIME || id == CLOCK_REALTIME_COARSE)) {
        long long ns = now->tv_sec * 1000000000LL + now->tv_nsec + atoll(text) * 1000000LL;
        now->tv_sec = ns / 1000000000LL;
        now->tv_nsec = ns % 1000000000LL;
    }
    return (int)done;
}
