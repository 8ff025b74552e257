/* gnomon: pixel-perfect, alias-free hard shadows. Everything at once. */
#ifndef GNOMON_GNOMON_H
#define GNOMON_GNOMON_H

#include <gnomon/antialias.h>
#include <gnomon/device.h>
#include <gnomon/image.h>
#include <gnomon/measure.h>
#include <gnomon/method.h>
#include <gnomon/procedural.h>
#include <gnomon/scene.h>
#include <gnomon/shadow_map.h>
#include <gnomon/view.h>

#endif
