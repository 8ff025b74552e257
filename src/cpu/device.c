#include "cpu/cpu.h"

#include <stdio.h>

static gn_isa best_isa(void)
{
#if defined(__x86_64__)
    __builtin_cpu_init();
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
        __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512bw"))
        return GN_ISA_AVX512;
    if (__builtin_cpu_supports("avx2"))
        return GN_ISA_AVX2;
#endif
    return GN_ISA_SCALAR;
}

static const gn_kernels *find_kernels(gn_isa isa)
{
#if defined(__x86_64__)
    if (isa == GN_ISA_AVX512)
        return &gn_kernels_avx512;
    if (isa == GN_ISA_AVX2)
        return &gn_kernels_avx2;
#endif
    (void)isa;
    return &gn_kernels_scalar;
}

gn_result gn_cpu_create(gn_context *context, gn_isa isa, gn_cpu *cpu)
{
    const gn_isa best = best_isa();
    if ((int)isa < (int)GN_ISA_AUTO || isa > GN_ISA_AVX512)
        return gn_fail(context, GN_ERROR_INVALID_ARGUMENT, "instruction set %d does not exist",
                       (int)isa);
    if (isa > best)
        return gn_fail(context, GN_ERROR_UNSUPPORTED,
                       "this processor does not have the instruction set %s",
                       isa == GN_ISA_AVX512 ? "avx512" : "avx2");
    cpu->context = context;
    cpu->isa = isa == GN_ISA_AUTO ? best : isa;
    cpu->kernels = find_kernels(cpu->isa);
    gn_tables_fill(&cpu->tables);

    /* Embree takes the same limit, so that "scalar" means a processor without AVX. */
    char config[64];
    const char *name = cpu->isa == GN_ISA_AVX512 ? "avx512"
                       : cpu->isa == GN_ISA_AVX2 ? "avx2"
                                                 : "sse4.2";
#if defined(__x86_64__)
    snprintf(config, sizeof config, "threads=%u,isa=%s", context->threads, name);
#else
    (void)name;
    snprintf(config, sizeof config, "threads=%u", context->threads);
#endif
    cpu->rtc = rtcNewDevice(config);
    if (!cpu->rtc)
        return gn_fail(context, GN_ERROR_UNSUPPORTED, "Embree cannot start (error %d)",
                       (int)rtcGetDeviceError(NULL));
    const long version = (long)rtcGetDeviceProperty(cpu->rtc, RTC_DEVICE_PROPERTY_VERSION);
    snprintf(cpu->version, sizeof cpu->version, "%ld.%ld.%ld", version / 10000, version / 100 % 100,
             version % 100);
    return GN_OK;
}

void gn_cpu_destroy(gn_cpu *cpu)
{
    if (cpu->rtc)
        rtcReleaseDevice(cpu->rtc);
    cpu->rtc = NULL;
}
