/* The glTF reader: what is in a good file arrives in the scene. */
#include "glb_testing.h"

static const gn_part *part_of(const gn_scene *scene, uint32_t mesh, uint32_t part)
{
    assert_in_range(mesh, 0, scene->mesh_count - 1);
    assert_in_range(part, 0, scene->meshes[mesh].part_count - 1);
    return &scene->meshes[mesh].parts[part];
}

static bool has_warning(const gn_scene *scene, const char *text)
{
    for (uint32_t i = 0; i < scene->warning_count; i++) {
        if (strstr(scene->warnings[i], text))
            return true;
    }
    return false;
}

/* Meshes ------------------------------------------------------------------------------------ */

static void quad(void **state)
{
    (void)state;
    gn_scene *scene = read_good(NULL, 0, "", "", QUAD_SCENE);
    const gn_part *part = part_of(scene, 0, 0);
    assert_int_equal(part->vertex_count, 4);
    assert_int_equal(part->triangle_count, 2);
    assert_floats(part->positions, quad_positions, 12, 0);
    assert_null(part->normals);
    assert_memory_equal(part->indices, ((uint32_t[]){0, 1, 2, 0, 2, 3}), 24);
    assert_int_equal(scene->warning_count, 0);
    gn_scene_destroy(&scene);
}

/* Strips keep the winding of every triangle; fans and lists without indices too. */
static void strips_and_fans(void **state)
{
    (void)state;
    static const uint8_t order[5] = {0, 1, 3, 2, 0};
    gn_scene *scene = read_good(
        order, sizeof order, ",{'buffer':0,'byteOffset':92,'byteLength':5}",
        ",{'bufferView':3,'componentType':5121,'type':'SCALAR','count':5}",
        "'meshes':[{'primitives':[{'attributes':{'POSITION':0},'indices':3,'mode':5},"
        "{'attributes':{'POSITION':0},'mode':6},{'attributes':{'POSITION':0},'mode':1}]}],"
        "'nodes':[{'mesh':0}]");
    assert_int_equal(scene->meshes[0].part_count, 2);
    assert_int_equal(part_of(scene, 0, 0)->triangle_count, 3);
    assert_memory_equal(part_of(scene, 0, 0)->indices, ((uint32_t[]){0, 1, 3, 1, 2, 3, 3, 2, 0}),
                        36);
    assert_int_equal(part_of(scene, 0, 1)->triangle_count, 2);
    assert_memory_equal(part_of(scene, 0, 1)->indices, ((uint32_t[]){1, 2, 0, 2, 3, 0}), 24);
    assert_true(has_warning(scene, "mesh 0, primitive 2: points and lines"));
    gn_scene_destroy(&scene);
}

static void sparse_positions(void **state)
{
    (void)state;
    struct {
        uint8_t places[4];
        float values[6];
    } bin = {{1, 3}, {5, 6, 7, -1, -2, -3}};
    gn_scene *scene = read_good(
        &bin, sizeof bin,
        ",{'buffer':0,'byteOffset':92,'byteLength':2},{'buffer':0,'byteOffset':96,'byteLength':24}",
        ",{'bufferView':0,'componentType':5126,'type':'VEC3','count':4,'sparse':{'count':2,"
        "'indices':{'bufferView':3,'componentType':5121},'values':{'bufferView':4}}},"
        "{'componentType':5126,'type':'VEC3','count':4,'sparse':{'count':2,"
        "'indices':{'bufferView':3,'componentType':5121},'values':{'bufferView':4}}}",
        "'meshes':[{'primitives':[{'attributes':{'POSITION':3},'indices':2},"
        "{'attributes':{'POSITION':4},'indices':2}]}],'nodes':[{'mesh':0}]");
    assert_floats(part_of(scene, 0, 0)->positions, (float[]){0, 0, 0, 5, 6, 7, 1, 1, 0, -1, -2, -3},
                  12, 0);
    assert_floats(part_of(scene, 0, 1)->positions, (float[]){0, 0, 0, 5, 6, 7, 0, 0, 0, -1, -2, -3},
                  12, 0);
    gn_scene_destroy(&scene);
}

/* KHR_mesh_quantization with a byteStride: signed normalized positions are clamped at -1. */
static void quantized_attributes(void **state)
{
    (void)state;
    static const int16_t positions[3][4] = {{32767, 0, -32768}, {0, 16384, 0}, {-32767, 0, 0}};
    static const int8_t normals[3][4] = {{0, 0, 127}, {0, -128, 0}, {127, 0, 0}};
    static const uint8_t uvs[3][4] = {{0, 255}, {51, 102}, {7, 9}};
    uint8_t bin[48];
    memcpy(bin, positions, 24);
    memcpy(bin + 24, normals, 12);
    memcpy(bin + 36, uvs, 12);
    gn_scene *scene = read_good(
        bin, sizeof bin,
        ",{'buffer':0,'byteOffset':92,'byteLength':22,'byteStride':8},"
        "{'buffer':0,'byteOffset':116,'byteLength':12,'byteStride':4},"
        "{'buffer':0,'byteOffset':128,'byteLength':12,'byteStride':4}",
        ",{'bufferView':3,'componentType':5122,'type':'VEC3','count':3,'normalized':true},"
        "{'bufferView':4,'componentType':5120,'type':'VEC3','count':3,'normalized':true},"
        "{'bufferView':5,'componentType':5121,'type':'VEC2','count':3,'normalized':true},"
        "{'bufferView':5,'componentType':5121,'type':'VEC2','count':3}",
        "'extensionsRequired':['KHR_mesh_quantization'],"
        "'images':[{'uri':'data:image/png;base64," PNG_2X1 "'}],'textures':[{'source':0}],"
        "'materials':[{'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}}],"
        "'meshes':[{'primitives':[{'attributes':{'POSITION':3,'NORMAL':4,"
        "'TEXCOORD_0':5},'material':0},{'attributes':{'POSITION':3,'TEXCOORD_0':6},"
        "'material':0}]}],'nodes':[{'mesh':0}]");
    const gn_part *part = part_of(scene, 0, 0);
    assert_floats(part->positions, (float[]){1, 0, -1, 0, 16384.0f / 32767, 0, -1, 0, 0}, 9, 1e-7f);
    assert_floats(part->normals, (float[]){0, 0, 1, 0, -1, 0, 1, 0, 0}, 9, 1e-7f);
    assert_floats(part->uvs, (float[]){0, 1, 0.2f, 0.4f}, 4, 1e-7f);
    assert_floats(part_of(scene, 0, 1)->uvs, (float[]){0, 255, 51, 102, 7, 9}, 6, 0);
    gn_scene_destroy(&scene);
}

/* Materials --------------------------------------------------------------------------------- */

#define TEXTURED                                                                                   \
    "'images':[{'uri':'data:image/png;base64," PNG_2X1 "'}],"                                      \
    "'samplers':[{'wrapS':33071,'wrapT':33648}],"                                                  \
    "'textures':[{'source':0,'sampler':0},{'source':0}],"

static void material_values(void **state)
{
    (void)state;
    gn_scene *scene = read_good(
        NULL, 0, "", "",
        TEXTURED
        "'materials':[{'name':'leaf','alphaMode':'MASK','alphaCutoff':0.25,'doubleSided':true,"
        "'pbrMetallicRoughness':{'baseColorFactor':[0.5,0.25,1,0.75],'baseColorTexture':"
        "{'index':0}}},{'alphaMode':'BLEND','pbrMetallicRoughness':{'baseColorTexture':{'index':1}}"
        "},{}],'meshes':[" QUAD_MESH "],'nodes':[{'mesh':0}]");
    assert_int_equal(scene->texture_count, 1); /* one image, however many textures */
    assert_int_equal(scene->textures[0].width, 2);
    assert_int_equal(scene->textures[0].height, 1);
    assert_memory_equal(scene->textures[0].rgba[0], "\xff\0\0\xff\0\xff\0\x40", 8);
    const gn_material_desc *leaf = &scene->materials[0].desc;
    assert_string_equal(scene->materials[0].name, "leaf");
    assert_floats(leaf->base_color, (float[]){0.5f, 0.25f, 1, 0.75f}, 4, 0);
    assert_int_equal(leaf->alpha_mode, GN_ALPHA_MASK);
    assert_floats(&leaf->alpha_cutoff, (float[]){0.25f}, 1, 0);
    assert_true(leaf->double_sided);
    assert_int_equal(leaf->wrap_u, GN_WRAP_CLAMP);
    assert_int_equal(leaf->wrap_v, GN_WRAP_MIRROR);
    const gn_material_desc *blend = &scene->materials[1].desc, *plain = &scene->materials[2].desc;
    assert_int_equal(blend->alpha_mode, GN_ALPHA_BLEND);
    assert_int_equal(blend->wrap_u, GN_WRAP_REPEAT);
    assert_int_equal(plain->alpha_mode, GN_ALPHA_OPAQUE);
    assert_int_equal(plain->texture, GN_NONE);
    assert_false(plain->double_sided);
    gn_scene_destroy(&scene);
}

/* The example of KHR_texture_transform's text: the lower left quadrant, rotated clockwise. */
static void uv_transform(void **state)
{
    (void)state;
    gn_scene *scene = read_good(
        NULL, 0, "", "",
        TEXTURED "'extensionsUsed':['KHR_texture_transform'],"
                 "'materials':[{'pbrMetallicRoughness':{'baseColorTexture':{'index':0,'texCoord':9,"
                 "'extensions':{'KHR_texture_transform':{'offset':[0,1],'rotation':1.57079632679,"
                 "'scale':[0.5,0.5],'texCoord':0}}}}}],'meshes':[" QUAD_MESH
                 "],'nodes':[{'mesh':0}]");
    assert_floats(part_of(scene, 0, 0)->uvs, (float[]){0.5f, 1, 0.5f, 0.5f, 0, 0.5f, 0, 1}, 8,
                  1e-6f);
    assert_int_equal(scene->warning_count, 0);
    gn_scene_destroy(&scene);
}

static void second_uv_set(void **state)
{
    (void)state;
    static const float uvs[8] = {9, 8, 7, 6, 5, 4, 3, 2};
    gn_scene *scene = read_good(
        uvs, sizeof uvs, ",{'buffer':0,'byteOffset':92,'byteLength':32}",
        ",{'bufferView':3,'componentType':5126,'type':'VEC2','count':4}",
        TEXTURED
        "'materials':[{'pbrMetallicRoughness':{'baseColorTexture':{'index':0,'texCoord':1}}}],"
        "'meshes':[{'primitives':[{'attributes':{'POSITION':0,'TEXCOORD_0':1,'TEXCOORD_1':3},"
        "'indices':2,'material':0},{'attributes':{'POSITION':0,'TEXCOORD_0':1},'indices':2,"
        "'material':0}]}],'nodes':[{'mesh':0}]");
    assert_floats(part_of(scene, 0, 0)->uvs, uvs, 8, 0);
    assert_null(part_of(scene, 0, 1)->uvs);
    assert_true(has_warning(scene, "mesh 0, primitive 1: it has no TEXCOORD_1"));
    gn_scene_destroy(&scene);
}

/* Nodes ------------------------------------------------------------------------------------- */

static void instances_share_a_mesh(void **state)
{
    (void)state;
    gn_scene *scene = read_good(
        NULL, 0, "", "",
        "'materials':[{}],'meshes':[" QUAD_MESH "],'scene':0,'scenes':[{'nodes':[3,0]}],"
        "'nodes':[{'name':'root','children':[1,2],'translation':[1,2,3],'scale':[2,2,2]},"
        "{'mesh':0,'rotation':[0,0,1,0]},{'mesh':0,'matrix':[1,0,0,0,0,1,0,0,0,0,1,0,7,8,9,1]},"
        "{'mesh':0},{'name':'elsewhere','mesh':0}]");
    const gn_scene_info info = gn_scene_get_info(scene);
    assert_int_equal(info.nodes, 4);
    assert_int_equal(info.meshes, 1);
    assert_int_equal(info.mesh_nodes, 3);
    assert_int_equal(info.triangles, 2);
    assert_int_equal(info.instanced_triangles, 6);
    assert_true(has_warning(scene, "1 nodes are not in the default scene"));
    assert_string_equal(scene->nodes[1].name, "root"); /* in the scene's order, parents first */
    assert_int_equal(scene->nodes[2].desc.parent, 1);
    assert_int_equal(scene->nodes[3].desc.parent, 1);
    assert_int_equal(gn_scene_resolve(scene), GN_OK);
    assert_floats(scene->nodes[2].world + 12, (float[]){1, 2, 3, 1}, 4, 1e-6f);
    assert_floats(scene->nodes[2].world, (float[]){-2, 0, 0}, 3, 1e-6f);
    assert_floats(scene->nodes[3].world + 12, (float[]){15, 18, 21, 1}, 4, 1e-6f);
    gn_scene_destroy(&scene);
}

static void gpu_instancing(void **state)
{
    (void)state;
    struct {
        float translations[9];
        int8_t rotations[3][4];
    } bin = {{1, 0, 0, 2, 0, 0, 3, 0, 0}, {{0, 0, 0, 127}, {127, 0, 0, 0}, {0, 127, 0, 0}}};
    gn_scene *scene =
        read_good(&bin, sizeof bin,
                  ",{'buffer':0,'byteOffset':92,'byteLength':36},{'buffer':0,'byteOffset':128,"
                  "'byteLength':12}",
                  ",{'bufferView':3,'componentType':5126,'type':'VEC3','count':3},"
                  "{'bufferView':4,'componentType':5120,'type':'VEC4','count':3,'normalized':true}",
                  "'extensionsRequired':['EXT_mesh_gpu_instancing'],'materials':[{}],"
                  "'meshes':[" QUAD_MESH "],'nodes':[{'mesh':0,'translation':[0,5,0],'extensions':"
                  "{'EXT_mesh_gpu_instancing':{'attributes':{'TRANSLATION':3,'ROTATION':4}}}}]");
    const gn_scene_info info = gn_scene_get_info(scene);
    assert_int_equal(info.mesh_nodes, 3);
    assert_int_equal(info.instanced_triangles, 6);
    assert_int_equal(gn_scene_resolve(scene), GN_OK);
    assert_floats(scene->nodes[2].world + 12, (float[]){2, 5, 0}, 3, 1e-6f);
    assert_floats(scene->nodes[2].world + 4, (float[]){0, -1, 0}, 3, 1e-6f);
    assert_floats(scene->nodes[3].world, (float[]){-1, 0, 0}, 3, 1e-6f);
    gn_scene_destroy(&scene);
}

/* Lights and cameras ------------------------------------------------------------------------ */

static void lights(void **state)
{
    (void)state;
    gn_scene *scene = read_good(
        NULL, 0, "", "",
        "'materials':[{}],'meshes':[" QUAD_MESH "],"
        "'extensions':{'KHR_lights_punctual':{'lights':["
        "{'type':'spot','name':'Torch','color':[1,0.5,0.25],'intensity':7,'range':30,"
        "'spot':{'innerConeAngle':0.25,'outerConeAngle':0.5}},"
        "{'type':'directional','intensity':3},{'type':'point','extras':{'defaultOn':false}}]}},"
        "'nodes':[{'mesh':0},"
        "{'name':'a','translation':[1,2,3],'extensions':{'KHR_lights_punctual':{'light':0}}},"
        "{'name':'b','extras':{'defaultOn':false},'extensions':{'KHR_lights_punctual':{'light':0}}"
        "},{'name':'Sun','extensions':{'KHR_lights_punctual':{'light':1}}},"
        "{'name':'Off','extensions':{'KHR_lights_punctual':{'light':2}}}]");
    assert_int_equal(scene->light_count, 4);
    const gn_light_desc torch = gn_scene_get_light(scene, 0);
    assert_string_equal(gn_scene_light_name(scene, 0), "Torch");
    assert_int_equal(torch.type, GN_LIGHT_SPOT);
    assert_floats(torch.color, (float[]){1, 0.5f, 0.25f}, 3, 0);
    assert_floats(&torch.intensity, (float[]){7}, 1, 0);
    assert_floats(&torch.range, (float[]){30}, 1, 0);
    assert_floats(&torch.inner_cone_angle, (float[]){0.25f}, 1, 0);
    assert_floats(&torch.outer_cone_angle, (float[]){0.5f}, 1, 0);
    assert_true(torch.on);
    assert_false(gn_scene_get_light(scene, 1).on); /* the same light on another node */
    assert_string_equal(gn_scene_light_name(scene, 2), "Sun");
    assert_int_equal(gn_scene_get_light(scene, 2).type, GN_LIGHT_DIRECTIONAL);
    assert_int_equal(gn_scene_get_light(scene, 3).type, GN_LIGHT_POINT);
    assert_true(isinf(gn_scene_get_light(scene, 3).range));
    assert_false(gn_scene_get_light(scene, 3).on);
    assert_int_equal(gn_scene_resolve(scene), GN_OK);
    assert_floats(scene->lights[0].position, (float[]){1, 2, 3}, 3, 0);
    assert_floats(scene->lights[0].direction, (float[]){0, 0, -1}, 3, 1e-7f);
    gn_scene_destroy(&scene);
}

static void cameras(void **state)
{
    (void)state;
    gn_scene *scene = read_good(
        NULL, 0, "", "",
        "'materials':[{}],'meshes':[" QUAD_MESH "],"
        "'cameras':[{'name':'lens','type':'perspective','perspective':{'yfov':0.75,'znear':0.5,"
        "'aspectRatio':2}},{'type':'orthographic','orthographic':{'xmag':3,'ymag':2,'znear':0,"
        "'zfar':9}}],'nodes':[{'mesh':0},{'name':'CamWalk','camera':0},{'camera':0},{'camera':1}]");
    assert_int_equal(scene->camera_count, 3);
    assert_int_equal(gn_scene_find_camera(scene, "CamWalk"), 0);
    assert_int_equal(gn_scene_find_camera(scene, "lens"), 1);
    assert_int_equal(gn_scene_find_camera(scene, "camera 1"), 2);
    const gn_camera_desc *walk = &scene->cameras[0].desc, *flat = &scene->cameras[2].desc;
    assert_false(walk->orthographic);
    assert_floats(&walk->yfov, (float[]){0.75f}, 1, 0);
    assert_floats(&walk->znear, (float[]){0.5f}, 1, 0);
    assert_true(flat->orthographic);
    assert_floats(&flat->ymag, (float[]){2}, 1, 0);
    gn_scene_destroy(&scene);
}

/* Animation --------------------------------------------------------------------------------- */

static void animations(void **state)
{
    (void)state;
    struct {
        float times[2], steps[6], splines[18];
        int16_t rotations[2][4];
    } bin = {{0, 2},
             {1, 2, 3, 4, 5, 6},
             {0, 0, 0, 1, 1, 1, 0, 0, 0, 0, 0, 0, 3, 3, 3, 0, 0, 0},
             {{0, 0, 0, 32767}, {0, 0, 32767, 0}}};
    gn_scene *scene = read_good(
        &bin, sizeof bin,
        ",{'buffer':0,'byteOffset':92,'byteLength':8},{'buffer':0,'byteOffset':100,'byteLength':24}"
        ",{'buffer':0,'byteOffset':124,'byteLength':72},{'buffer':0,'byteOffset':196,"
        "'byteLength':16}",
        ",{'bufferView':3,'componentType':5126,'type':'SCALAR','count':2},"
        "{'bufferView':4,'componentType':5126,'type':'VEC3','count':2},"
        "{'bufferView':5,'componentType':5126,'type':'VEC3','count':6},"
        "{'bufferView':6,'componentType':5122,'type':'VEC4','count':2,'normalized':true}",
        "'materials':[{}],'meshes':[" QUAD_MESH "],'nodes':[{'mesh':0}],"
        "'animations':[{'samplers':[{'input':3,'output':4,'interpolation':'STEP'},"
        "{'input':3,'output':5,'interpolation':'CUBICSPLINE'}],'channels':["
        "{'sampler':0,'target':{'node':0,'path':'translation'}},"
        "{'sampler':1,'target':{'node':0,'path':'scale'}},"
        "{'sampler':0,'target':{'node':0,'path':'weights'}},"
        "{'sampler':0,'target':{'path':'translation'}}]},"
        "{'samplers':[{'input':3,'output':6}],'channels':["
        "{'sampler':0,'target':{'node':0,'path':'rotation'}},"
        "{'sampler':0,'target':{'node':0,'path':'rotation'}}]}]");
    assert_int_equal(scene->channel_count, 3);
    assert_int_equal(scene->channels[0].desc.interpolation, GN_INTERPOLATION_STEP);
    assert_int_equal(scene->channels[1].desc.interpolation, GN_INTERPOLATION_CUBICSPLINE);
    assert_int_equal(scene->channels[2].desc.interpolation, GN_INTERPOLATION_LINEAR);
    assert_int_equal(scene->channels[2].desc.path, GN_PATH_ROTATION);
    assert_floats(scene->channels[2].desc.values, (float[]){0, 0, 0, 1, 0, 0, 1, 0}, 8, 0);
    assert_true(has_warning(scene, "animation 0, channel 2: animation of \"weights\""));
    assert_true(has_warning(scene, "animation 1, channel 1: the rotation of node 0 is animated"));
    assert_true(gn_scene_get_info(scene).duration == 2);
    assert_int_equal(gn_scene_set_time(scene, 1), GN_OK);
    /* Half way: the step's first value, the spline's mean 2, a quarter turn. */
    assert_floats(scene->nodes[0].local, (float[]){0, 2, 0, 0, -2, 0, 0, 0, 0, 0, 2, 0, 1, 2, 3, 1},
                  16, 1e-6f);
    gn_scene_destroy(&scene);
}

/* What is left out is named ----------------------------------------------------------------- */

static void warnings(void **state)
{
    (void)state;
    gn_scene *scene = read_good(
        NULL, 0, "", "",
        "'extensionsUsed':['EXT_something'],'materials':[{}],'skins':[{'name':'body','joints':[0]}]"
        ",'meshes':[{'name':'face','primitives':[{'attributes':{'POSITION':0,'COLOR_0':0},"
        "'indices':2,'targets':[{'POSITION':0}]}]}],'nodes':[{'mesh':0,'skin':0}]");
    assert_true(has_warning(scene, "EXT_something"));
    assert_true(has_warning(scene, "skin 0 \"body\": skins are not supported; the mesh is shown in "
                                   "its bind pose"));
    assert_true(has_warning(scene, "mesh 0 \"face\", primitive 0: vertex colours"));
    assert_true(has_warning(scene, "mesh 0 \"face\", primitive 0: morph targets"));
    assert_int_equal(gn_scene_get_info(scene).instanced_triangles, 2);
    gn_scene_destroy(&scene);
}

/* Files ------------------------------------------------------------------------------------- */

/* A .gltf whose buffer and image lie beside it, under names that need percent signs. */
static void external_files(void **state)
{
    (void)state;
    char folder[] = "/tmp/gnomon-gltf-XXXXXX", path[128];
    assert_non_null(mkdtemp(folder));
    glb file;
    make_glb(&file, NULL, 0, "", "", QUAD_SCENE);
    static const char json[] =
        "{\"asset\":{\"version\":\"2.0\"},\"buffers\":[{\"byteLength\":36,\"uri\":\"a%20b%23.bin\"}"
        "],"
        "\"bufferViews\":[{\"buffer\":0,\"byteLength\":36}],\"accessors\":[{\"bufferView\":0,"
        "\"componentType\":5126,\"type\":\"VEC3\",\"count\":3}],"
        "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}],"
        "\"nodes\":[{\"mesh\":0}]}";
    snprintf(path, sizeof path, "%s/a b#.bin", folder);
    write_file(path, quad_positions, 36);
    snprintf(path, sizeof path, "%s/scene.gltf", folder);
    write_file(path, json, sizeof json - 1);
    gn_scene *scene = NULL;
    if (gn_scene_load(test_device(), path, &scene) != GN_OK)
        fail_msg("%s", gn_device_message(test_device()));
    assert_floats(part_of(scene, 0, 0)->positions, quad_positions, 9, 0);
    gn_scene_destroy(&scene);
    unlink(path);
    snprintf(path, sizeof path, "%s/a b#.bin", folder);
    unlink(path);
    rmdir(folder);
}

typedef struct expected_counts {
    const char *name;
    uint32_t nodes, mesh_nodes, meshes, materials, masked_materials, textures, lights, cameras;
    uint64_t triangles, instanced, masked, instanced_masked;
} expected_counts;

/* The optional scenes in the folder GNOMON_SCENES; the figures are their README's. */
static void real_scenes(void **state)
{
    (void)state;
    static const expected_counts all[] = {
        {"grove.glb", 1387, 1381, 57, 60, 34, 60, 2, 4, 71862, 347709, 13262, 276477},
        {"court.glb", 123, 116, 52, 46, 10, 46, 2, 5, 79580, 104938, 4274, 7958},
        {"leafbox.glb", 10, 6, 6, 4, 1, 1, 1, 3, 586, 586, 576, 576}};
    const char *folder = getenv("GNOMON_SCENES");
    if (!folder) {
        print_message("GNOMON_SCENES is not set: the real scenes are skipped\n");
        skip();
    }
    for (size_t i = 0; i < sizeof all / sizeof *all; i++) {
        char path[1024];
        snprintf(path, sizeof path, "%s/%s", folder, all[i].name);
        gn_scene *scene = NULL;
        assert_int_equal(gn_scene_create(test_device(), &scene), GN_OK);
        if (gn_import_gltf(scene, path) != GN_OK)
            fail_msg("%s", gn_device_message(test_device()));
        const gn_scene_info info = gn_scene_get_info(scene);
        assert_int_equal(info.nodes, all[i].nodes);
        assert_int_equal(info.mesh_nodes, all[i].mesh_nodes);
        assert_int_equal(info.meshes, all[i].meshes);
        assert_int_equal(info.materials, all[i].materials);
        assert_int_equal(info.masked_materials, all[i].masked_materials);
        assert_int_equal(info.textures, all[i].textures);
        assert_int_equal(info.lights, all[i].lights);
        assert_int_equal(info.cameras, all[i].cameras);
        assert_int_equal(info.triangles, all[i].triangles);
        assert_int_equal(info.instanced_triangles, all[i].instanced);
        assert_int_equal(info.masked_triangles, all[i].masked);
        assert_int_equal(info.instanced_masked_triangles, all[i].instanced_masked);
        assert_int_equal(info.warning_count, 0);
        assert_true(info.duration == 10);
        const uint32_t lamp = gn_scene_find_light(scene, "Lamp");
        assert_true(lamp == GN_NONE || !gn_scene_get_light(scene, lamp).on);
        gn_scene_destroy(&scene);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(quad),
        cmocka_unit_test(strips_and_fans),
        cmocka_unit_test(sparse_positions),
        cmocka_unit_test(quantized_attributes),
        cmocka_unit_test(material_values),
        cmocka_unit_test(uv_transform),
        cmocka_unit_test(second_uv_set),
        cmocka_unit_test(instances_share_a_mesh),
        cmocka_unit_test(gpu_instancing),
        cmocka_unit_test(lights),
        cmocka_unit_test(cameras),
        cmocka_unit_test(animations),
        cmocka_unit_test(warnings),
        cmocka_unit_test(external_files),
        cmocka_unit_test(real_scenes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
