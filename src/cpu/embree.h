/* The one place that knows whether Embree 3 or 4 is underneath.
 *
 * Call signatures that differ get a gn_rtc_ name; everything else is Embree's own API, which both
 * versions share. Packets of 16 only: Embree splits them where the processor is narrower. */
#ifndef GN_CPU_EMBREE_H
#define GN_CPU_EMBREE_H

#if defined(__has_include)
#if __has_include(<embree4/rtcore.h>)
#define GN_EMBREE_4 1
#endif
#endif

#ifdef GN_EMBREE_4

#include <embree4/rtcore.h>

typedef struct RTCRayQueryContext gn_rtc_context;

static inline void gn_rtc_context_init(gn_rtc_context *context)
{
    rtcInitRayQueryContext(context);
}

static inline void gn_rtc_occluded1(RTCScene scene, gn_rtc_context *context, struct RTCRay *ray)
{
    struct RTCOccludedArguments arguments;
    rtcInitOccludedArguments(&arguments);
    arguments.context = context;
    rtcOccluded1(scene, ray, &arguments);
}

static inline void gn_rtc_occluded16(const int *valid, RTCScene scene, gn_rtc_context *context,
                                     struct RTCRay16 *ray)
{
    struct RTCOccludedArguments arguments;
    rtcInitOccludedArguments(&arguments);
    arguments.context = context;
    rtcOccluded16(valid, scene, ray, &arguments);
}

static inline void gn_rtc_intersect16_coherent(const int *valid, RTCScene scene,
                                               gn_rtc_context *context, struct RTCRayHit16 *ray)
{
    struct RTCIntersectArguments arguments;
    rtcInitIntersectArguments(&arguments);
    arguments.context = context;
    arguments.flags = RTC_RAY_QUERY_FLAG_COHERENT;
    rtcIntersect16(valid, scene, ray, &arguments);
}

#else

#include <embree3/rtcore.h>

typedef struct RTCIntersectContext gn_rtc_context;

static inline void gn_rtc_context_init(gn_rtc_context *context)
{
    rtcInitIntersectContext(context);
}

static inline void gn_rtc_occluded1(RTCScene scene, gn_rtc_context *context, struct RTCRay *ray)
{
    context->flags = RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
    rtcOccluded1(scene, context, ray);
}

/* Never with the coherent flag: on AVX-512, Embree 3.13.5 then loops forever in instanced scenes
 * once incoherent calls ran before. */
static inline void gn_rtc_occluded16(const int *valid, RTCScene scene, gn_rtc_context *context,
                                     struct RTCRay16 *ray)
{
    context->flags = RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
    rtcOccluded16(valid, scene, context, ray);
}

static inline void gn_rtc_intersect16_coherent(const int *valid, RTCScene scene,
                                               gn_rtc_context *context, struct RTCRayHit16 *ray)
{
    context->flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    rtcIntersect16(valid, scene, context, ray);
}

#endif

/* Fields of a filter's ray and hit, in the order of struct RTCRay and struct RTCHit, an array of
 * count each. Embree's own accessors are for C++ only. */
enum { GN_RAY_DIR_X = 4, GN_RAY_DIR_Y, GN_RAY_DIR_Z, GN_RAY_TFAR = 8, GN_RAY_ID = 10 };
enum {
    GN_HIT_NG_X = 0,
    GN_HIT_NG_Y,
    GN_HIT_NG_Z,
    GN_HIT_U,
    GN_HIT_V,
    GN_HIT_PRIMITIVE,
    GN_HIT_GEOMETRY,
    GN_HIT_INSTANCE
};

static inline float gn_lane_real(const void *record, int field, unsigned count, unsigned lane)
{
    return ((const float *)record)[(unsigned)field * count + lane];
}

static inline unsigned gn_lane_id(const void *record, int field, unsigned count, unsigned lane)
{
    return ((const unsigned *)record)[(unsigned)field * count + lane];
}

#endif
