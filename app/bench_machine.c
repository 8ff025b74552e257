#include "bench_machine.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <linux/perf_event.h>

const char *const gn_counter_names[GN_COUNTER_COUNT] = {"instructions", "cycles", "cache_misses",
                                                        "branch_misses"};

static const uint64_t events[GN_COUNTER_COUNT] = {
    PERF_COUNT_HW_INSTRUCTIONS, PERF_COUNT_HW_CPU_CYCLES, PERF_COUNT_HW_CACHE_MISSES,
    PERF_COUNT_HW_BRANCH_MISSES};

/* Counters ------------------------------------------------------------------------------------ */

static int open_event(uint64_t event)
{
    struct perf_event_attr attributes = {.type = PERF_TYPE_HARDWARE,
                                         .size = sizeof attributes,
                                         .config = event,
                                         .read_format = PERF_FORMAT_TOTAL_TIME_ENABLED |
                                                        PERF_FORMAT_TOTAL_TIME_RUNNING,
                                         .inherit = 1,
                                         .exclude_kernel = 1,
                                         .exclude_hv = 1};
    return (int)syscall(SYS_perf_event_open, &attributes, 0, -1, -1, PERF_FLAG_FD_CLOEXEC);
}

static void explain(gn_machine *machine, int error)
{
    char level[16] = "?";
    FILE *file = fopen("/proc/sys/kernel/perf_event_paranoid", "r");
    if (file && !fgets(level, sizeof level, file))
        strcpy(level, "?");
    if (file)
        fclose(file);
    level[strcspn(level, "\n")] = '\0';
    if (error == EACCES || error == EPERM)
        snprintf(machine->reason, sizeof machine->reason,
                 "the system does not allow them (/proc/sys/kernel/perf_event_paranoid is %s)",
                 level);
    else if (error == ENOENT || error == EOPNOTSUPP || error == ENODEV)
        snprintf(machine->reason, sizeof machine->reason,
                 "the processor or virtual machine shows none");
    else
        snprintf(machine->reason, sizeof machine->reason, "perf_event_open: %s", strerror(error));
}

void gn_machine_read(const gn_machine *machine, double counts[GN_COUNTER_COUNT])
{
    for (int i = 0; i < GN_COUNTER_COUNT; i++) {
        uint64_t values[3]; /* count, time enabled, time running */
        counts[i] = NAN;
        if (machine->files[i] >= 0 &&
            read(machine->files[i], values, sizeof values) == (ssize_t)sizeof values &&
            values[2] > 0)
            counts[i] = (double)values[0] * ((double)values[1] / (double)values[2]);
    }
}

/* Load ---------------------------------------------------------------------------------------- */

/* Seconds of all processors together since the machine started; false where /proc does not tell. */
static bool read_processors(double *busy, double *total)
{
    /* user, nice, system, idle, iowait, irq, softirq, steal (another virtual machine had it) */
    unsigned long long t[8];
    FILE *file = fopen("/proc/stat", "r");
    const bool good = file && fscanf(file, "cpu %llu %llu %llu %llu %llu %llu %llu %llu", &t[0],
                                     &t[1], &t[2], &t[3], &t[4], &t[5], &t[6], &t[7]) == 8;
    if (file)
        fclose(file);
    *busy = *total = 0;
    for (int i = 0; i < 8 && good; i++) {
        const double seconds = (double)t[i] / (double)sysconf(_SC_CLK_TCK);
        *total += seconds;
        *busy += i == 3 || i == 4 ? 0 : seconds;
    }
    return good && *total > 0;
}

static double own_seconds(void)
{
    struct rusage usage;
    if (getrusage(RUSAGE_SELF, &usage) != 0)
        return 0;
    return (double)usage.ru_utime.tv_sec + (double)usage.ru_stime.tv_sec +
           1e-6 * ((double)usage.ru_utime.tv_usec + (double)usage.ru_stime.tv_usec);
}

double gn_machine_others(const gn_machine *machine)
{
    double busy, total;
    if (machine->total <= 0 || !read_processors(&busy, &total) || !(total > machine->total))
        return NAN;
    const double others = busy - machine->busy - (own_seconds() - machine->own);
    return fmin(fmax(others / (total - machine->total), 0), 1);
}

/* Both ---------------------------------------------------------------------------------------- */

void gn_machine_open(gn_machine *machine)
{
    *machine = (gn_machine){0};
    for (int i = 0; i < GN_COUNTER_COUNT; i++) {
        machine->files[i] = open_event(events[i]);
        if (machine->files[i] < 0 && i == 0)
            explain(machine, errno);
        machine->counts = machine->counts || machine->files[i] >= 0;
    }
    if (!read_processors(&machine->busy, &machine->total))
        machine->total = 0;
    machine->own = own_seconds();
}

void gn_machine_close(gn_machine *machine)
{
    for (int i = 0; i < GN_COUNTER_COUNT; i++)
        if (machine->files[i] >= 0)
            close(machine->files[i]);
}
