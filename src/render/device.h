#ifndef GN_RENDER_DEVICE_H
#define GN_RENDER_DEVICE_H

#include "cpu/cpu.h"

struct gn_device {
    gn_context context; /* must be first: gn_device_context() */
    gn_cpu cpu;
};

#endif
