/* Histories in files: what a history is, down to the bit, except that maps are drawn again.
 *
 * Little-endian: "GNHISTOR", version, fingerprint of the scene, the caller's note, picture, lights,
 * masks, depth, the view's last frame, and a checksum of all that. Every field is named once, in
 * one function for both ways. */
#include "render/history_file.h"

#include <inttypes.h>
#include <string.h>

#include "render/shadow_map.h"
#include "render/stream.h"
#include "scene/file.h"
#include "scene/scene.h"

enum { VERSION = 2, MAGIC_BYTES = 8, CHECKSUM_BYTES = 8 };

static const char magic[] = "GNHISTOR";

/* The scene ----------------------------------------------------------------------------------- */

gn_fingerprint gn_fingerprint_make(const gn_scene *scene)
{
    gn_fingerprint made = {.nodes = scene->node_count,
                           .meshes = scene->mesh_count,
                           .materials = scene->material_count,
                           .lights = scene->light_count,
                           .cameras = scene->camera_count};
    uint64_t sum = GN_CHECKSUM_START;
    for (uint32_t i = 0; i < scene->mesh_count; i++) {
        const gn_mesh *mesh = &scene->meshes[i];
        for (uint32_t p = 0; p < mesh->part_count; p++) {
            const gn_part *part = &mesh->parts[p];
            const uint32_t sizes[3] = {part->vertex_count, part->triangle_count, part->material};
            made.vertices += sizes[0];
            made.triangles += sizes[1];
            sum = gn_checksum(sum, sizes, sizeof sizes);
        }
        sum = gn_checksum(sum, mesh->bounds_min, sizeof mesh->bounds_min);
        sum = gn_checksum(sum, mesh->bounds_max, sizeof mesh->bounds_max);
    }
    for (uint32_t i = 0; i < scene->node_count; i++) {
        const gn_node_desc *node = &scene->nodes[i].desc;
        const uint32_t links[4] = {node->parent, node->mesh, node->light, node->camera};
        sum = gn_checksum(sum, links, sizeof links);
        sum = gn_checksum(sum, node->translation, sizeof node->translation);
        sum = gn_checksum(sum, node->rotation, sizeof node->rotation);
        sum = gn_checksum(sum, node->scale, sizeof node->scale);
        sum = gn_checksum(sum, node->matrix, sizeof node->matrix);
    }
    for (uint32_t i = 0; i < scene->material_count; i++) {
        const gn_material_desc *material = &scene->materials[i].desc;
        const uint32_t mode = (uint32_t)material->alpha_mode;
        sum = gn_checksum(sum, &mode, sizeof mode);
        sum = gn_checksum(sum, &material->alpha_cutoff, sizeof material->alpha_cutoff);
    }
    made.digest = sum;
    return made;
}

/* mine: of the scene that is loaded for, when reading. */
static void fingerprint(gn_stream *s, const gn_fingerprint *mine)
{
    const struct {
        const char *name;
        uint64_t value;
    } fields[] = {{"nodes", mine->nodes},         {"meshes", mine->meshes},
                  {"materials", mine->materials}, {"lights", mine->lights},
                  {"cameras", mine->cameras},     {"vertices", mine->vertices},
                  {"triangles", mine->triangles}};
    s->what = "the scene";
    for (size_t i = 0; i < sizeof fields / sizeof *fields; i++) {
        uint64_t value = fields[i].value;
        gn_stream_number(s, &value, 8);
        if (s->result == GN_OK && value != fields[i].value)
            s->result = gn_fail(s->context, GN_ERROR_INVALID_ARGUMENT,
                                "%s: it belongs to another scene, of %" PRIu64 " %s; this one has "
                                "%" PRIu64,
                                s->name, value, fields[i].name, fields[i].value);
    }
    uint64_t digest = mine->digest;
    gn_stream_number(s, &digest, 8);
    if (s->result == GN_OK && digest != mine->digest)
        s->result = gn_fail(s->context, GN_ERROR_INVALID_ARGUMENT,
                            "%s: it belongs to another scene, whose meshes, nodes or materials are "
                            "others",
                            s->name);
}

/* The note ------------------------------------------------------------------------------------ */

static void note(gn_stream *s, gn_history *history)
{
    uint32_t length = s->file && history->note ? (uint32_t)strlen(history->note) : 0;
    s->what = "the note";
    gn_stream_word(s, &length);
    if (length > GN_MAX_NOTE)
        gn_stream_refuse(s, "is too long");
    if (length == 0 || !gn_stream_has(s, length, 1))
        return;
    if (!s->file && !(history->note = gn_alloc_zero(s->context, length + 1, 1)))
        s->result = gn_fail(s->context, GN_ERROR_OUT_OF_MEMORY, "%s: out of memory", s->name);
    if (s->result == GN_OK)
        gn_stream_bytes(s, (uint8_t *)history->note, length);
}

/* Maps ---------------------------------------------------------------------------------------- */

static void format(gn_stream *s, gn_map_format *f)
{
    f->kind = (gn_map_kind)gn_stream_choice(s, (uint32_t)f->kind, GN_MAP_NLMSM + 1);
    gn_stream_word(s, &f->bits);
    gn_stream_flag(s, &f->single_depth);
    gn_stream_flag(s, &f->one_sided);
    gn_stream_reals(s, &f->positive_exponent, 1);
    gn_stream_reals(s, &f->negative_exponent, 1);
    gn_stream_word(s, &f->pcf_width);
    f->bound = (gn_moment_bound)gn_stream_choice(s, (uint32_t)f->bound, GN_BOUND_HAUSDORFF + 1);
}

static void settings(gn_stream *s, gn_map_desc *d)
{
    gn_stream_word(s, &d->resolution);
    gn_stream_word(s, &d->samples);
    d->alpha = (gn_map_alpha)gn_stream_choice(s, (uint32_t)d->alpha, GN_MAP_ALPHA_OPAQUE + 1);
    gn_stream_word(s, &d->cascades);
    gn_stream_reals(s, &d->distance, 1);
    gn_stream_reals(s, &d->split_weight, 1);
    gn_stream_word(s, &d->split_count);
    gn_stream_reals(s, d->splits, GN_MAX_CASCADES);
    gn_stream_word(s, &d->undrawn);
    gn_stream_reals(s, &d->enlarge, 1);
    gn_stream_word(s, &d->filter_width);
    gn_stream_reals(s, &d->filter_sigma, 1);
    gn_stream_flag(s, &d->mip_maps);
    d->reading = (gn_map_reading)gn_stream_choice(s, (uint32_t)d->reading, GN_READING_BILINEAR + 1);
    gn_stream_reals(s, &d->depth_bias, 1);
    gn_stream_reals(s, &d->normal_bias, 1);
    gn_stream_reals(s, &d->minimum_variance, 1);
    gn_stream_reals(s, &d->moment_bias, 1);
    gn_stream_word(s, &d->refresh);
    gn_stream_word(s, &d->seed);
}

static void place(gn_stream *s, gn_map_place *p)
{
    gn_stream_reals(s, p->direction, 3);
    gn_stream_reals(s, p->origin, 3);
    gn_stream_reals(s, &p->extent, 1);
    gn_stream_reals(s, &p->near, 1);
    gn_stream_reals(s, &p->far, 1);
    gn_stream_word(s, &p->whole);
    gn_stream_doubles(s, p->low, 3);
    gn_stream_doubles(s, p->high, 3);
}

static void state(gn_stream *s, gn_map_state *m)
{
    gn_stream_word(s, &m->moving);
    gn_stream_word(s, &m->type);
    gn_stream_reals(s, m->light, 3);
    gn_stream_reals(s, m->axis, 3);
    gn_stream_reals(s, &m->range, 1);
    gn_stream_reals(s, &m->outer, 1);
    gn_stream_reals(s, m->camera, 16);
    gn_stream_reals(s, m->sun, 3);
    gn_stream_word(s, &m->has_camera);
    for (uint32_t i = 0; i < GN_MAX_CASCADES; i++) {
        gn_map_layer_state *layer = &m->layers[i];
        gn_stream_word(s, &layer->used);
        gn_stream_word(s, &layer->parts);
        place(s, &layer->front);
        place(s, &layer->back);
    }
}

/* A field that is added and not named above would be lost. */
_Static_assert(sizeof(gn_map_place) == 88, "place() names every field");
_Static_assert(sizeof(gn_map_state) == 8 + 8 * 4 + 20 * 4 + GN_MAX_CASCADES * (8 + 2 * 88),
               "state() names every field");
_Static_assert(sizeof(gn_map_format) == 28, "format() names every field");
_Static_assert(sizeof(gn_map_desc) == 28 * 4, "settings() names every field");

/* Lights -------------------------------------------------------------------------------------- */

/* How old something of the history is. Older things are as good as none. */
typedef enum age { NOW = 0, BEFORE = 1, NEVER = 2 } age;

static age age_of(const gn_history *history, uint64_t frame)
{
    return frame == 0 || frame + 1 < history->frame ? NEVER
           : frame == history->frame                ? NOW
                                                    : BEFORE;
}

static uint64_t frame_of(const gn_history *history, age when)
{
    return when == NEVER ? 0 : history->frame - (when == BEFORE ? 1 : 0);
}

static void light_entry(gn_stream *s, const gn_history *history, gn_history_entry *e,
                        gn_map_state *map)
{
    gn_stream_word(s, &e->light);
    e->asked = frame_of(history, (age)gn_stream_choice(s, age_of(history, e->asked), NEVER + 1));
    e->masked = frame_of(history, (age)gn_stream_choice(s, age_of(history, e->masked), NEVER + 1));
    gn_stream_word(s, &e->slot);
    format(s, &e->format);
    settings(s, &e->desc);
    state(s, map);
}

static void write_light(gn_stream *s, const gn_history *history, const gn_history_entry *entry)
{
    gn_history_entry e = *entry;
    if (age_of(history, e.masked) == NEVER)
        e.slot = 0;
    gn_map_state map;
    gn_shadow_map_save_state(e.map, &map);
    light_entry(s, history, &e, &map);
}

static void check_light(gn_stream *s, const gn_history *history, const gn_scene *scene,
                        const gn_history_entry *e)
{
    if (e->light >= scene->light_count)
        gn_stream_refuse(s, "does not exist");
    if (e->masked > 0 && (e->slot >= GN_MAX_MASKS || 3 * e->slot + 3 > 8 * history->texel_bytes))
        gn_stream_refuse(s, "has its bits outside the mask's texel");
    for (uint32_t i = 0; i < history->count; i++) {
        const gn_history_entry *o = &history->entries[i];
        if (o->light == e->light)
            gn_stream_refuse(s, "is there twice");
        if (o->masked > 0 && e->masked > 0 && o->slot == e->slot)
            gn_stream_refuse(s, "has the bits of another light");
    }
}

static void read_light(gn_stream *s, gn_history *history, const gn_scene *scene)
{
    gn_history_entry e = {.desc = gn_map_desc_default()};
    gn_map_state map = {0};
    light_entry(s, history, &e, &map);
    check_light(s, history, scene, &e);
    if (s->result != GN_OK)
        return;
    if (!gn_grow(s->context, (void **)&history->entries, history->count, &history->capacity,
                 sizeof *history->entries)) {
        s->result = gn_fail(s->context, GN_ERROR_OUT_OF_MEMORY, "%s: out of memory", s->name);
        return;
    }
    gn_stream_blame(s, gn_shadow_map_create(history->device, &e.format, &e.desc, &e.map));
    if (s->result == GN_OK)
        gn_stream_blame(s, gn_shadow_map_restore_state(e.map, scene, e.light, &map));
    history->entries[history->count++] = e; /* and its map: it is the history's now */
}

static void lights(gn_stream *s, gn_history *history, const gn_scene *scene)
{
    uint32_t count = 0;
    for (uint32_t i = 0; i < history->count; i++)
        count += history->entries[i].map != NULL;
    s->what = "the list of lights";
    gn_stream_word(s, &count);
    char name[32];
    for (uint32_t i = 0, n = history->count; s->file && i < n; i++)
        if (history->entries[i].map)
            write_light(s, history, &history->entries[i]);
    for (uint32_t i = 0; !s->file && i < count && s->result == GN_OK; i++) {
        snprintf(name, sizeof name, "light %u of %u", i + 1, count);
        s->what = name;
        read_light(s, history, scene);
    }
    s->what = "the file";
}

/* Masks and depth ----------------------------------------------------------------------------- */

/* One texture with the newest mask of every light; bits of lights that have none are 0. */
static void write_masks(gn_stream *s, const gn_history *history)
{
    uint8_t keep[2][16] = {{0}}, raw[4096];
    for (uint32_t i = 0; i < history->count; i++) {
        const gn_history_entry *e = &history->entries[i];
        for (uint32_t bit = 3 * e->slot; bit < 3 * e->slot + 3; bit++)
            if (age_of(history, e->masked) != NEVER)
                keep[e->side][bit / 8] |= (uint8_t)(1u << bit % 8);
    }
    const size_t size = (size_t)history->width * history->height * history->texel_bytes;
    for (size_t first = 0; first < size; first += sizeof raw) {
        const size_t part = size - first < sizeof raw ? size - first : sizeof raw;
        for (size_t i = 0; i < part; i++) {
            const size_t at = i % history->texel_bytes; /* 4096 holds whole texels */
            raw[i] = (uint8_t)((history->masks[0][first + i] & keep[0][at]) |
                               (history->masks[1][first + i] & keep[1][at]));
        }
        gn_stream_bytes(s, raw, part);
    }
}

static void read_masks(gn_stream *s, gn_history *history)
{
    const uint64_t pixels = (uint64_t)history->width * history->height;
    s->what = "a mask";
    if (history->texel_bytes == 0 || !gn_stream_has(s, pixels, history->texel_bytes))
        return;
    for (int side = 0; side < 2; side++)
        history->masks[side] = gn_alloc_zero(s->context, pixels, history->texel_bytes);
    if (history->masks[0] && history->masks[1])
        gn_stream_bytes(s, history->masks[0], pixels * history->texel_bytes);
    else
        s->result = gn_fail(s->context, GN_ERROR_OUT_OF_MEMORY, "%s: out of memory", s->name);
}

static void depth_plane(gn_stream *s, gn_history *history, int side, age when)
{
    const uint64_t pixels = (uint64_t)history->width * history->height;
    bool there = s->file && age_of(history, history->depth_frame[side]) == when;
    s->what = "depth";
    gn_stream_flag(s, &there);
    if (!there || !gn_stream_has(s, pixels, sizeof(float)))
        return;
    if (!s->file) {
        history->depth[side] = gn_alloc(s->context, pixels, sizeof(float));
        history->depth_frame[side] = frame_of(history, when);
        if (!history->depth[side])
            s->result = gn_fail(s->context, GN_ERROR_OUT_OF_MEMORY, "%s: out of memory", s->name);
    }
    if (s->result == GN_OK)
        gn_stream_reals(s, history->depth[side], pixels);
}

/* That of the frame at hand, and that of the frame before where a light is still to come. */
static void depth_planes(gn_stream *s, gn_history *history)
{
    const int now = history->depth_frame[1] > history->depth_frame[0];
    depth_plane(s, history, now, NOW);
    bool waiting = false;
    for (uint32_t i = 0; i < history->count; i++)
        waiting |= age_of(history, history->entries[i].masked) == BEFORE;
    if (waiting)
        depth_plane(s, history, !now, BEFORE);
}

/* Size and camera; texel_bytes 0: no light has a mask. */
static void picture(gn_stream *s, gn_history *history)
{
    uint32_t texel_bytes = 0;
    for (uint32_t i = 0; i < history->count; i++)
        if (age_of(history, history->entries[i].masked) != NEVER)
            texel_bytes = history->texel_bytes;
    s->what = "the picture";
    gn_stream_word(s, &history->width);
    gn_stream_word(s, &history->height);
    gn_stream_word(s, &history->camera);
    gn_stream_word(s, &texel_bytes);
    if (texel_bytes > 16 || (texel_bytes & (texel_bytes - 1)) != 0)
        gn_stream_refuse(s, "has masks of a size that does not exist");
    history->texel_bytes = texel_bytes;
}

/* The frame before ---------------------------------------------------------------------------- */

static void rays(gn_stream *s, gn_rays *r)
{
    float *const axes[] = {r->origin, r->right, r->up, r->back};
    for (int i = 0; i < 4; i++)
        gn_stream_reals(s, axes[i], 3);
    gn_stream_flag(s, &r->orthographic);
    gn_stream_reals(s, &r->near, 1);
    gn_stream_reals(s, &r->cone_width, 1);
    gn_stream_reals(s, &r->cone_angle, 1);
    if (!gn_all_finite(axes[0], 3) || !gn_all_finite(axes[1], 3) || !gn_all_finite(axes[2], 3) ||
        !gn_all_finite(axes[3], 3) || !gn_all_finite(&r->near, 1))
        gn_stream_refuse(s, "has a camera that is not finite");
}

_Static_assert(sizeof(gn_rays) == 16 * 4, "rays() names every field");

static void frame_fields(gn_stream *s, gn_last_frame *last)
{
    gn_stream_word(s, &last->width);
    gn_stream_word(s, &last->height);
    rays(s, &last->rays);
    const size_t count = 16 * (size_t)last->node_count;
    if (!s->file && gn_stream_has(s, count, sizeof(float))) {
        last->world = gn_alloc(s->context, count + 1, sizeof(float));
        if (!last->world)
            s->result = gn_fail(s->context, GN_ERROR_OUT_OF_MEMORY, "%s: out of memory", s->name);
    }
    if (s->result == GN_OK)
        gn_stream_reals(s, last->world, count);
    if (s->result == GN_OK && !gn_all_finite(last->world, count))
        gn_stream_refuse(s, "has a node that is not finite");
}

static void write_frame(gn_stream *s, const gn_last_frame *last)
{
    bool there = last != NULL;
    gn_stream_flag(s, &there);
    if (!there)
        return;
    gn_last_frame copy = *last;
    frame_fields(s, &copy);
}

/* last: what the view wants, or NULL. */
static void read_frame(gn_stream *s, const gn_scene *scene, gn_last_frame *last)
{
    bool there = false;
    s->what = "the frame before";
    gn_stream_flag(s, &there);
    if (!there && last)
        gn_stream_refuse(s, "is missing: the file was not written from a view");
    if (!there || s->result != GN_OK)
        return;
    gn_last_frame read = {.valid = true, .scene = scene->number, .node_count = scene->node_count};
    frame_fields(s, &read);
    if (s->result == GN_OK && last && (read.width != last->width || read.height != last->height))
        s->result = gn_fail(s->context, GN_ERROR_INVALID_ARGUMENT,
                            "%s: it is of a picture of %u x %u pixels; this one has %u x %u",
                            s->name, read.width, read.height, last->width, last->height);
    if (s->result == GN_OK && last)
        *last = read;
    else
        gn_free(s->context, read.world);
}

/* Files --------------------------------------------------------------------------------------- */

static gn_result write_all(gn_stream *s, const gn_history *history, const gn_last_frame *last)
{
    uint8_t head[MAGIC_BYTES];
    memcpy(head, magic, sizeof head);
    gn_stream_bytes(s, head, sizeof head);
    uint32_t version = VERSION;
    gn_stream_word(s, &version);
    gn_history copy = *history; /* fields are named by pointers that reading writes through */
    fingerprint(s, &copy.fingerprint);
    note(s, &copy);
    picture(s, &copy);
    lights(s, &copy, NULL);
    write_masks(s, &copy);
    depth_planes(s, &copy);
    write_frame(s, last);
    uint64_t sum = s->sum;
    gn_stream_number(s, &sum, CHECKSUM_BYTES);
    return s->result;
}

gn_result gn_history_write(const gn_history *history, const gn_last_frame *last, const char *path)
{
    gn_context *context = gn_device_context(history->device);
    if (history->scene == 0)
        return gn_fail(context, GN_ERROR_STATE, "%s: the history is empty",
                       path ? path : "(no path)");
    gn_file file;
    GN_TRY(gn_file_begin(context, path, &file));
    gn_stream s = {.context = context, .name = path, .file = &file, .sum = GN_CHECKSUM_START};
    const gn_result result = write_all(&s, history, last);
    if (result == GN_OK)
        return gn_file_commit(&file);
    gn_file_abort(&file);
    return result;
}

static gn_result read_all(gn_stream *s, const gn_scene *scene, gn_history *history,
                          gn_last_frame *last)
{
    uint32_t version = 0;
    s->at = MAGIC_BYTES;
    gn_stream_word(s, &version);
    if (version != VERSION)
        return gn_fail(s->context, GN_ERROR_UNSUPPORTED,
                       "%s: a history of version %u, where this program reads version %u", s->name,
                       version, VERSION);
    uint64_t sum = 0;
    for (size_t i = 0; i < CHECKSUM_BYTES; i++)
        sum |= (uint64_t)s->data[s->size + i] << 8 * i;
    if (sum != gn_checksum(GN_CHECKSUM_START, s->data, s->size)) {
        gn_stream_refuse(s, "is damaged: its checksum is that of other data");
        return s->result;
    }
    history->fingerprint = gn_fingerprint_make(scene);
    history->scene = scene->number;
    history->structure = scene->structure_version;
    history->frame = 2; /* counted anew: nothing depends on more than before and after */
    fingerprint(s, &history->fingerprint);
    note(s, history);
    picture(s, history);
    lights(s, history, scene);
    read_masks(s, history);
    depth_planes(s, history);
    read_frame(s, scene, last);
    s->what = "the file";
    if (s->at < s->size)
        gn_stream_refuse(s, "goes on behind its end");
    return s->result;
}

gn_result gn_history_read_memory(const gn_scene *scene, const char *name, const uint8_t *data,
                                 size_t size, gn_history **history, gn_last_frame *last)
{
    gn_context *context = scene->context;
    *history = NULL;
    if (!scene->accel || scene->edits != scene->committed)
        return gn_fail(context, GN_ERROR_STATE, "%s: the scene has edits that are not committed",
                       name);
    if (size < MAGIC_BYTES + 4 + CHECKSUM_BYTES || memcmp(data, magic, MAGIC_BYTES) != 0)
        return gn_fail(context, GN_ERROR_FORMAT, "%s: the file holds no history of gnomon", name);
    GN_TRY(gn_history_create(scene->device, history));
    gn_stream s = {.context = context,
                   .name = name,
                   .what = "the file",
                   .data = data,
                   .size = size - CHECKSUM_BYTES};
    const gn_result result = read_all(&s, scene, *history, last);
    if (result != GN_OK)
        gn_history_destroy(history);
    return result;
}

gn_result gn_history_read(const gn_scene *scene, const char *path, gn_history **history,
                          gn_last_frame *last)
{
    gn_context *context = scene->context;
    *history = NULL;
    if (!path || !*path)
        return gn_fail(context, GN_ERROR_INVALID_ARGUMENT, "cannot read: the path is empty");
    uint8_t *data;
    uint64_t size;
    const char *reason = gn_file_read(context, path, &data, &size);
    if (reason)
        return gn_fail(context, GN_ERROR_IO, "%s: cannot read: %s", path, reason);
    const gn_result result = gn_history_read_memory(scene, path, data, size, history, last);
    gn_free(context, data);
    return result;
}

gn_result gn_history_save(const gn_history *history, const char *path)
{
    return gn_history_write(history, NULL, path);
}

gn_result gn_history_load(const gn_scene *scene, const char *path, gn_history **history)
{
    return gn_history_read(scene, path, history, NULL);
}
