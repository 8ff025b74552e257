/* What tests of histories share: a scene of many lights, pictures without content, and masks that
 * are read and written bit by bit. */
#ifndef HISTORY_TESTING_H
#define HISTORY_TESTING_H

#include "render_testing.h"

#include "render/history.h"

static const gn_map_format vsm = {.kind = GN_MAP_VSM, .bits = 64, .single_depth = true};

static inline gn_map_desc tiny_map(void)
{
    gn_map_desc desc = gn_map_desc_default();
    desc.resolution = 32;
    desc.cascades = 1;
    desc.filter_width = 1;
    desc.refresh = 1;
    return desc;
}

/* A floor, a box over it, a camera and so many suns. */
static inline gn_scene *many_lights(uint32_t lights)
{
    gn_scene *scene = new_scene();
    place(scene, add_floor(scene, 3, 0, GN_NONE), false);
    place(scene, add_box(scene, v3(-1, 0.5, -1), v3(1, 1, 1), GN_NONE), false);
    for (uint32_t i = 0; i < lights; i++)
        add_sun(scene, v3(0.1 * i - 1, 2, 0.3));
    add_camera(scene, v3(2, 3, 5), v3(0, 0, 0), 0.7, 0.1);
    add_camera(scene, v3(-2, 3, 5), v3(0, 0, 0), 0.7, 0.1);
    ok(gn_scene_commit(scene));
    return scene;
}

static inline gn_history *new_history(gn_device *of)
{
    gn_history *history = NULL;
    check_ok(gn_history_create(of, &history), "gn_history_create()", __FILE__, __LINE__);
    return history;
}

/* One light of one frame, as gn_scene_visibility() asks for it. */
static inline gn_result begin_mask(gn_history *history, const gn_scene *scene, uint32_t light,
                                   const gn_gbuffer *gbuffer, bool keep_depth, gn_leak_mask *mask)
{
    const gn_map_desc desc = tiny_map();
    gn_shadow_map *map;
    *mask = (gn_leak_mask){.before = NULL};
    GN_TRY(gn_history_reserve_map(history, scene, light, &vsm, &desc, &map));
    return gn_history_begin_mask(history, light, 0, gbuffer, keep_depth, mask);
}

static inline gn_leak_mask begin(gn_history *history, const gn_scene *scene, uint32_t light,
                                 const gn_gbuffer *gbuffer, bool keep_depth)
{
    gn_leak_mask mask;
    ok(begin_mask(history, scene, light, gbuffer, keep_depth, &mask));
    assert_non_null(mask.now);
    return mask;
}

static inline uint32_t get_state(const uint8_t *texels, const gn_leak_mask *mask, size_t pixel)
{
    uint32_t state = 0;
    for (uint32_t k = 0; k < 3; k++) {
        const size_t bit = 8 * pixel * mask->texel_bytes + mask->first_bit + k;
        state |= (uint32_t)(texels[bit / 8] >> bit % 8 & 1) << k;
    }
    return state;
}

static inline void set_state(const gn_leak_mask *mask, size_t pixel, uint32_t state)
{
    for (uint32_t k = 0; k < 3; k++) {
        const size_t bit = 8 * pixel * mask->texel_bytes + mask->first_bit + k;
        mask->now[bit / 8] =
            (uint8_t)((mask->now[bit / 8] & ~(1u << bit % 8)) | (state >> k & 1) << bit % 8);
    }
}

static inline uint32_t random_below(uint64_t *state, uint32_t count)
{
    *state = *state * 6364136223846793005u + 1442695040888963407u;
    return (uint32_t)((*state >> 33) % count);
}

#endif
