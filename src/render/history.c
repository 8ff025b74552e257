#include "render/history.h"

#include <string.h>

#include "cpu/light_buffer.h"
#include "scene/scene.h"

/* Life ---------------------------------------------------------------------------------------- */

gn_result gn_history_create(gn_device *device, gn_history **history)
{
    gn_context *context = gn_device_context(device);
    *history = gn_alloc_zero(context, 1, sizeof **history);
    if (!*history)
        return gn_fail(context, GN_ERROR_OUT_OF_MEMORY, "out of memory for a history");
    (*history)->device = device;
    return GN_OK;
}

void gn_history_cut(gn_history *history)
{
    for (uint32_t i = 0; i < history->count; i++)
        history->entries[i].masked = 0;
    history->depth_frame[0] = history->depth_frame[1] = 0;
}

/* Cuts, and gives the memory back. */
static void drop_picture(gn_history *history)
{
    gn_context *context = gn_device_context(history->device);
    gn_history_cut(history);
    for (int side = 0; side < 2; side++) {
        gn_free(context, history->masks[side]);
        gn_free(context, history->depth[side]);
        history->masks[side] = NULL;
        history->depth[side] = NULL;
    }
    history->texel_bytes = 0;
}

void gn_history_reset(gn_history *history)
{
    drop_picture(history);
    for (uint32_t i = 0; i < history->count; i++)
        gn_shadow_map_destroy(&history->entries[i].map);
    history->count = 0;
    for (uint32_t i = 0; i < history->buffer_count; i++)
        gn_light_buffer_destroy(&history->buffers[i].buffer);
    history->buffer_count = 0;
    history->scene = 0;
}

void gn_history_reset_maps(gn_history *history)
{
    for (uint32_t i = 0; i < history->count; i++)
        if (history->entries[i].map)
            gn_shadow_map_reset(history->entries[i].map);
}

void gn_history_destroy(gn_history **history)
{
    if (!history || !*history)
        return;
    gn_history *h = *history;
    *history = NULL;
    gn_context *context = gn_device_context(h->device);
    gn_history_reset(h);
    gn_free(context, h->entries);
    gn_free(context, h->buffers);
    gn_free(context, h->note);
    gn_free(context, h);
}

gn_result gn_history_set_note(gn_history *history, const char *note)
{
    gn_context *context = gn_device_context(history->device);
    const size_t length = note ? strlen(note) : 0;
    if (length > GN_MAX_NOTE)
        return gn_fail(context, GN_ERROR_INVALID_ARGUMENT, "a note of %zu bytes: the most is %u",
                       length, GN_MAX_NOTE);
    char *copy = NULL;
    if (length > 0 && !(copy = gn_alloc_copy(context, note, length + 1, 1)))
        return gn_fail(context, GN_ERROR_OUT_OF_MEMORY, "out of memory for a note");
    gn_free(context, history->note);
    history->note = copy;
    return GN_OK;
}

const char *gn_history_note(const gn_history *history)
{
    return history->note ? history->note : "";
}

void gn_history_take(gn_history *history, gn_history **from)
{
    const gn_history old = *history;
    *history = **from;
    **from = old;
    gn_history_destroy(from);
}

/* Maps ---------------------------------------------------------------------------------------- */

static gn_history_entry *find(const gn_history *history, uint32_t light)
{
    for (uint32_t i = 0; i < history->count; i++)
        if (history->entries[i].light == light)
            return &history->entries[i];
    return NULL;
}

const gn_shadow_map *gn_history_map(const gn_history *history, uint32_t light)
{
    const gn_history_entry *e = find(history, light);
    return e ? e->map : NULL;
}

/* Field by field: padding may differ. */
static bool same_format(const gn_map_format *a, const gn_map_format *b)
{
    return a->kind == b->kind && a->bits == b->bits && a->single_depth == b->single_depth &&
           a->one_sided == b->one_sided && a->positive_exponent == b->positive_exponent &&
           a->negative_exponent == b->negative_exponent && a->pcf_width == b->pcf_width &&
           a->bound == b->bound;
}

static bool same_settings(const gn_map_desc *a, const gn_map_desc *b)
{
    return a->resolution == b->resolution && a->samples == b->samples && a->alpha == b->alpha &&
           a->cascades == b->cascades && a->distance == b->distance &&
           a->split_weight == b->split_weight && a->split_count == b->split_count &&
           memcmp(a->splits, b->splits, sizeof a->splits) == 0 && a->undrawn == b->undrawn &&
           a->enlarge == b->enlarge && a->filter_width == b->filter_width &&
           a->filter_sigma == b->filter_sigma && a->mip_maps == b->mip_maps &&
           a->reading == b->reading && a->depth_bias == b->depth_bias &&
           a->normal_bias == b->normal_bias && a->minimum_variance == b->minimum_variance &&
           a->moment_bias == b->moment_bias && a->refresh == b->refresh && a->seed == b->seed;
}

void gn_history_begin_frame(gn_history *history)
{
    history->frame++;
}

gn_result gn_history_use_scene(gn_history *history, const gn_scene *scene)
{
    if (scene->device != history->device)
        return gn_fail(scene->context, GN_ERROR_INVALID_ARGUMENT,
                       "the history was made by another device than the scene");
    const bool another = history->scene != scene->number;
    if (another)
        gn_history_reset(history);
    if (another || history->structure != scene->structure_version) {
        gn_history_cut(history);
        history->fingerprint = gn_fingerprint_make(scene);
    }
    history->scene = scene->number;
    history->structure = scene->structure_version;
    history->fingerprint.lights = scene->light_count; /* they are no part of the structure */
    history->fingerprint.cameras = scene->camera_count;
    return GN_OK;
}

gn_result gn_history_reserve_map(gn_history *history, const gn_scene *scene, uint32_t light,
                                 const gn_map_format *format, const gn_map_desc *desc,
                                 gn_shadow_map **map)
{
    gn_context *context = gn_device_context(history->device);
    *map = NULL;
    GN_TRY(gn_history_use_scene(history, scene));
    gn_history_entry *e = find(history, light);
    if (e && (!same_format(&e->format, format) || !same_settings(&e->desc, desc)))
        gn_shadow_map_destroy(&e->map);
    if (!e) {
        if (!gn_grow(context, (void **)&history->entries, history->count, &history->capacity,
                     sizeof *history->entries))
            return gn_fail(context, GN_ERROR_OUT_OF_MEMORY, "out of memory for a shadow map");
        e = &history->entries[history->count++];
        *e = (gn_history_entry){.light = light};
    }
    if (e->asked == history->frame)
        gn_history_begin_frame(history);
    e->asked = history->frame;
    if (!e->map) {
        e->masked = 0; /* it is of another map */
        GN_TRY(gn_shadow_map_create(history->device, format, desc, &e->map));
    }
    e->format = *format;
    e->desc = *desc;
    *map = e->map;
    return GN_OK;
}

/* Light buffers ------------------------------------------------------------------------------- */

gn_result gn_history_reserve_light_buffer(gn_history *history, const gn_scene *scene,
                                          uint32_t light, gn_light_buffer **buffer, size_t *others)
{
    gn_context *context = gn_device_context(history->device);
    *buffer = NULL;
    *others = 0;
    GN_TRY(gn_history_use_scene(history, scene));
    for (uint32_t i = 0; i < history->buffer_count; i++)
        if (history->buffers[i].light == light)
            *buffer = history->buffers[i].buffer;
        else
            *others += history->buffers[i].buffer->info.bytes;
    if (*buffer)
        return GN_OK;
    if (!gn_grow(context, (void **)&history->buffers, history->buffer_count,
                 &history->buffer_capacity, sizeof *history->buffers))
        return gn_fail(context, GN_ERROR_OUT_OF_MEMORY, "out of memory for a light buffer");
    GN_TRY(gn_light_buffer_create(context, buffer));
    history->buffers[history->buffer_count++] = (gn_history_buffer){light, *buffer};
    return GN_OK;
}

gn_result gn_history_draw_light_buffer(const gn_history *history, uint32_t light, uint32_t face,
                                       uint32_t size, float *lengths, float *extent)
{
    gn_context *context = gn_device_context(history->device);
    if (face >= GN_LIGHT_FACES || size == 0 || size > 16384)
        return gn_fail(context, GN_ERROR_INVALID_ARGUMENT,
                       "face %u in %u x %u pixels: faces are 0 to 5, sizes 1 to 16384", face, size,
                       size);
    for (uint32_t i = 0; i < history->buffer_count; i++)
        if (history->buffers[i].light == light) {
            gn_light_buffer_draw(history->buffers[i].buffer, face, size, lengths, extent);
            return GN_OK;
        }
    return gn_fail(context, GN_ERROR_INVALID_ARGUMENT, "light %u has no light buffer", light);
}

/* Masks --------------------------------------------------------------------------------------- */

size_t gn_history_mask_bytes(const gn_history *history)
{
    const size_t pixels = (size_t)history->width * history->height;
    size_t bytes = 0;
    for (int side = 0; side < 2; side++) {
        bytes += history->masks[side] ? pixels * history->texel_bytes : 0;
        bytes += history->depth[side] ? pixels * sizeof(float) : 0;
    }
    return bytes;
}

static gn_result fail_memory(const gn_history *history, const char *what)
{
    return gn_fail(gn_device_context(history->device), GN_ERROR_OUT_OF_MEMORY,
                   "out of memory for %s of %u x %u pixels", what, history->width, history->height);
}

/* Makes room for `slots` lights a texel; what the textures hold stays. */
static gn_result reserve_slots(gn_history *history, uint32_t slots)
{
    uint32_t bytes = 1;
    while (8 * bytes < 3 * slots)
        bytes *= 2;
    if (bytes <= history->texel_bytes)
        return GN_OK;
    gn_context *context = gn_device_context(history->device);
    const size_t pixels = (size_t)history->width * history->height;
    uint8_t *made[2];
    for (int side = 0; side < 2; side++) {
        made[side] = gn_alloc_zero(context, pixels, bytes);
        if (!made[side]) {
            gn_free(context, side == 1 ? made[0] : NULL);
            return fail_memory(history, "masks");
        }
    }
    for (int side = 0; side < 2; side++) {
        for (size_t i = 0; i < pixels && history->masks[side]; i++)
            memcpy(made[side] + i * bytes, history->masks[side] + i * history->texel_bytes,
                   history->texel_bytes);
        gn_free(context, history->masks[side]);
        history->masks[side] = made[side];
    }
    history->texel_bytes = bytes;
    return GN_OK;
}

/* The lowest slot that no mask of the frame `oldest` or a later one is in. */
static uint32_t find_slot(const gn_history *history, uint64_t oldest)
{
    uint64_t held = 0;
    for (uint32_t i = 0; i < history->count; i++)
        if (history->entries[i].masked > 0 && history->entries[i].masked >= oldest)
            held |= (uint64_t)1 << history->entries[i].slot;
    return (uint32_t)__builtin_ctzll(~held);
}

/* A light that has no mask of the frame before takes a slot of one that has none either. Where all
 * are held, it is that of a light which was not asked for in this frame yet. */
static gn_result take_slot(gn_history *history, gn_history_entry *e)
{
    e->masked = 0;
    uint32_t slot = find_slot(history, history->frame - 1);
    if (slot >= GN_MAX_MASKS)
        slot = find_slot(history, history->frame);
    if (slot >= GN_MAX_MASKS)
        return gn_fail(gn_device_context(history->device), GN_ERROR_UNSUPPORTED,
                       "light %u: a frame has masks of at most %u lights", e->light, GN_MAX_MASKS);
    GN_TRY(reserve_slots(history, slot + 1));
    for (uint32_t i = 0; i < history->count; i++)
        if (history->entries[i].slot == slot)
            history->entries[i].masked = 0;
    e->slot = slot;
    return GN_OK;
}

/* Keeps a frame's depth, once for all lights. *before: that of the frame before, or NULL. */
static gn_result keep_depth(gn_history *history, const gn_gbuffer *gbuffer, const float **before)
{
    gn_context *context = gn_device_context(history->device);
    int now = history->depth_frame[1] > history->depth_frame[0];
    if (history->depth_frame[now] != history->frame) {
        now = !now;
        if (!gbuffer->depth)
            return gn_fail(context, GN_ERROR_INVALID_ARGUMENT,
                           "the G-buffer has no depth, which the depth test of masks needs");
        const size_t pixels = (size_t)history->width * history->height;
        if (!history->depth[now])
            history->depth[now] = gn_alloc(context, pixels, sizeof(float));
        if (!history->depth[now])
            return fail_memory(history, "depth");
        memcpy(history->depth[now], gbuffer->depth, pixels * sizeof(float));
        history->depth_frame[now] = history->frame;
    }
    const bool kept =
        history->depth_frame[!now] > 0 && history->depth_frame[!now] + 1 == history->frame;
    *before = kept ? history->depth[!now] : NULL;
    return GN_OK;
}

gn_result gn_history_begin_mask(gn_history *history, uint32_t light, uint32_t camera,
                                const gn_gbuffer *gbuffer, bool keep, gn_leak_mask *mask)
{
    *mask = (gn_leak_mask){.before = NULL};
    gn_history_entry *e = find(history, light);
    if (!e || e->asked != history->frame)
        return gn_fail(gn_device_context(history->device), GN_ERROR_STATE,
                       "light %u: a mask without a map", light);
    if (gbuffer->width != history->width || gbuffer->height != history->height)
        drop_picture(history);
    else if (camera != history->camera)
        gn_history_cut(history);
    history->width = gbuffer->width;
    history->height = gbuffer->height;
    history->camera = camera;
    const float *depth_before = NULL;
    if (keep)
        GN_TRY(keep_depth(history, gbuffer, &depth_before));
    if (e->masked > 0 && e->masked + 1 == history->frame) {
        mask->before = history->masks[e->side];
        mask->depth_before = depth_before;
    } else {
        GN_TRY(take_slot(history, e));
    }
    e->side ^= 1;
    e->masked = history->frame;
    mask->now = history->masks[e->side];
    mask->texel_bytes = history->texel_bytes;
    mask->first_bit = 3 * e->slot;
    return GN_OK;
}
