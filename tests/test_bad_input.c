/* Broken and hostile scenes: a message that names the file, the thing and the reason, never a
 * crash, and nothing left behind. */
#include "glb_testing.h"

#include <sys/stat.h>

#define MESH "'materials':[{}],'meshes':[" QUAD_MESH "],"

/* The container ----------------------------------------------------------------------------- */

static void assert_nothing_held(size_t before)
{
    assert_int_equal(gn_device_bytes(test_device()), before);
}

/* Each prefix is copied, so that reads beyond its end are found. */
static void truncated_at_every_byte(void **state)
{
    (void)state;
    glb file;
    make_glb(&file, NULL, 0, "", "", QUAD_SCENE);
    const size_t before = gn_device_bytes(test_device());
    for (size_t size = 0; size < file.size; size++) {
        uint8_t *prefix = malloc(size + 1);
        assert_non_null(prefix);
        memcpy(prefix, file.data, size);
        assert_bad_bytes(prefix, size, "(memory): ", size < 4 ? "JSON" : "truncated");
        free(prefix);
    }
    assert_nothing_held(before);
}

/* The same through files: the message names the file. */
static void truncated_files(void **state)
{
    (void)state;
    glb file;
    make_glb(&file, NULL, 0, "", "", QUAD_SCENE);
    char path[] = "/tmp/gnomon-bad-XXXXXX.glb";
    const int descriptor = mkstemps(path, 4);
    assert_true(descriptor >= 0);
    close(descriptor);
    const size_t before = gn_device_bytes(test_device());
    for (size_t size = 0; size < file.size; size += 7) {
        write_file(path, file.data, size);
        gn_scene *scene = NULL;
        assert_int_not_equal(gn_scene_load(test_device(), path, &scene), GN_OK);
        assert_null(scene);
        if (strncmp(gn_device_message(test_device()), path, strlen(path)) != 0)
            fail_msg("\"%s\" does not begin with the file's name",
                     gn_device_message(test_device()));
    }
    unlink(path);
    assert_nothing_held(before);
}

/* Every byte of the headers and of the JSON, set to several values: no crash, nothing held. */
static void every_byte_changed(void **state)
{
    (void)state;
    glb file;
    make_glb(&file, NULL, 0, "", "", QUAD_SCENE);
    const size_t before = gn_device_bytes(test_device());
    static const uint8_t values[] = {0, 0xff, '9', '"', '{'};
    for (size_t i = 0; i < file.size; i++) {
        const uint8_t kept = file.data[i];
        for (size_t v = 0; v < sizeof values; v++) {
            file.data[i] = values[v];
            gn_scene *scene = NULL;
            assert_int_equal(gn_scene_create(test_device(), &scene), GN_OK);
            (void)gn_import_gltf_memory(scene, file.data, file.size);
            gn_scene_destroy(&scene);
        }
        file.data[i] = kept;
    }
    assert_nothing_held(before);
}

static void wrong_lengths(void **state)
{
    (void)state;
    glb good, file;
    make_glb(&good, NULL, 0, "", "", QUAD_SCENE);
    const size_t json = (size_t)good.data[12] | (size_t)good.data[13] << 8;
    file = good;
    put_u32(file.data + 4, 1);
    assert_bad_bytes(file.data, file.size, "GLB version 1", "not supported");
    file = good;
    put_u32(file.data + 8, file.size + 4);
    assert_bad_bytes(file.data, file.size, "truncated", "header says");
    file = good;
    put_u32(file.data + 8, file.size - 4);
    assert_bad_bytes(file.data, file.size, "wrong length", "header says");
    file = good;
    put_u32(file.data + 12, 0xfffffff0u);
    assert_bad_bytes(file.data, file.size, "chunk 0", "wrong length 4294967280");
    file = good;
    put_u32(file.data + 12, json - 1);
    assert_bad_bytes(file.data, file.size, "chunk 0", "wrong length");
    file = good;
    put_u32(file.data + 20 + json, 1000);
    assert_bad_bytes(file.data, file.size, "chunk 1", "wrong length 1000");
    file = good;
    memcpy(file.data + 16, "BIN", 4);
    assert_bad_bytes(file.data, file.size, "chunk 0", "must be JSON");
    file = good;
    memcpy(file.data + 24 + json, "TEXT", 4); /* without BIN the buffer has no bytes */
    assert_bad_bytes(file.data, file.size, "buffer 0", "neither a URI nor a BIN chunk");
}

/* A table of broken files ------------------------------------------------------------------- */

typedef struct bad_case {
    const char *views, *accessors, *rest, *first, *second;
} bad_case;

static void check_cases(const bad_case *cases, size_t count, const void *bin, size_t bin_size)
{
    const size_t before = gn_device_bytes(test_device());
    for (size_t i = 0; i < count; i++)
        assert_bad(bin, bin_size, cases[i].views, cases[i].accessors, cases[i].rest, cases[i].first,
                   cases[i].second);
    assert_nothing_held(before);
}

#define CHECK(cases, bin, size) check_cases(cases, sizeof cases / sizeof *cases, bin, size)
#define POSITION_3              "'meshes':[{'primitives':[{'attributes':{'POSITION':3}}]}]"

static void bad_accessors(void **state)
{
    (void)state;
    static const bad_case cases[] = {
        {"", ",{'bufferView':0,'componentType':5126,'type':'VEC3','count':5}",
         "'meshes':[{'name':'leaf','primitives':[{'attributes':{'POSITION':3}}]}]",
         "mesh 0 \"leaf\", primitive 0: accessor 3", "end beyond bufferView 0 (48 bytes)"},
        {"", ",{'bufferView':0,'byteOffset':4,'componentType':5126,'type':'VEC3','count':4}",
         POSITION_3, "accessor 3", "end beyond"},
        {"",
         ",{'bufferView':0,'byteOffset':9007199254740992,'componentType':5126,'type':'VEC3',"
         "'count':3}",
         POSITION_3, "accessor 3", "end beyond"},
        {"", ",{'bufferView':0,'componentType':5126,'type':'VEC3','count':4294967294}", POSITION_3,
         "accessor 3", "end beyond"},
        {"", ",{'componentType':5126,'type':'VEC3','count':4294967294}", POSITION_3, "accessor 3",
         "without a bufferView"},
        {"", ",{'bufferView':0,'componentType':5126,'type':'VEC3','count':18446744073709551616}",
         POSITION_3, "count", "not a non-negative integer"},
        {"", ",{'bufferView':0,'componentType':5126,'type':'VEC3','count':0}", POSITION_3,
         "accessor 3", "count 0"},
        {"", ",{'bufferView':0,'componentType':5127,'type':'VEC3','count':3}", POSITION_3,
         "accessor 3", "componentType 5127"},
        {"", ",{'bufferView':0,'componentType':5124,'type':'VEC3','count':3}", POSITION_3,
         "accessor 3", "componentType 5124"},
        {"", ",{'bufferView':0,'componentType':5126,'type':'MAT4','count':3}", POSITION_3,
         "accessor 3", "MAT4"},
        {"", ",{'bufferView':0,'componentType':5126,'type':'VEC2','count':3}", POSITION_3,
         "accessor 3", "2 components an element instead of 3"},
        {"", ",{'bufferView':0,'componentType':5125,'type':'VEC3','count':3}", POSITION_3,
         "accessor 3", "UNSIGNED_INT cannot be used"},
        {"", ",{'bufferView':7,'componentType':5126,'type':'VEC3','count':3}", POSITION_3,
         "no bufferView 7", "the count is 3"},
        {",{'buffer':0,'byteLength':48,'byteStride':8}",
         ",{'bufferView':3,'componentType':5126,'type':'VEC3','count':3}", POSITION_3, "accessor 3",
         "byteStride 8 for elements of 12 bytes"},
        {",{'buffer':0,'byteOffset':80,'byteLength':13}",
         ",{'bufferView':3,'componentType':5121,'type':'SCALAR','count':12}",
         "'meshes':[{'primitives':[{'attributes':{'POSITION':0},'indices':3}]}]", "bufferView 3",
         "ends beyond buffer 0 (92 bytes)"},
        {",{'buffer':1,'byteLength':4}",
         ",{'bufferView':3,'componentType':5121,'type':'SCALAR','count':3}",
         "'meshes':[{'primitives':[{'attributes':{'POSITION':0},'indices':3}]}]", "no buffer 1",
         "the count is 1"},
        {"",
         ",{'bufferView':0,'componentType':5126,'type':'VEC3','count':4,'sparse':{'count':5,"
         "'indices':{'bufferView':2,'componentType':5121},'values':{'bufferView':0}}}",
         POSITION_3, "accessor 3", "sparse has 5 elements"},
        {"",
         ",{'bufferView':0,'componentType':5126,'type':'VEC3','count':4,'sparse':{'count':4,"
         "'indices':{'bufferView':2,'componentType':5125},'values':{'bufferView':0}}}",
         POSITION_3, "sparse indices", "end beyond bufferView 2"},
        {"",
         ",{'bufferView':0,'componentType':5126,'type':'VEC3','count':4,'sparse':{'count':1,"
         "'indices':{'bufferView':0,'byteOffset':12,'componentType':5125},"
         "'values':{'bufferView':0}}}",
         POSITION_3, "accessor 3", "sparse index 1065353216 is out of range"},
        {"", ",{'bufferView':0,'componentType':5126,'type':'VEC3','count':3}",
         "'meshes':[{'primitives':[{'attributes':{'POSITION':3},'indices':2}]}]",
         "accessor 2: index 3 is out of range", "there are 3 vertices"},
        {"", ",{'bufferView':1,'componentType':5126,'type':'VEC2','count':3}",
         "'images':[{'uri':'data:;base64," PNG_2X1 "'}],'textures':[{'source':0}],"
         "'materials':[{'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}}],"
         "'meshes':[{'primitives':[{'attributes':{'POSITION':0,'TEXCOORD_0':3},'material':0}]}]",
         "TEXCOORD_0 has 3 elements", "POSITION has 4"},
        {"", "", "'meshes':[{'primitives':[{'attributes':{'POSITION':0}}]}]", "mesh 0, primitive 0",
         "4 indices do not make whole triangles"},
        {"", "", "'meshes':[{'primitives':[{'attributes':{'POSITION':0},'indices':0}]}]",
         "accessor 0", "cannot be used for indices"},
        {"", "", "'meshes':[{'primitives':[{'attributes':{'POSITION':0},'mode':7}]}]",
         "mesh 0, primitive 0", "unknown mode 7"},
        {"", "", "'meshes':[{'primitives':[{'attributes':{'POSITION':0},'material':2}]}]",
         "no material 2", "the count is 0"},
        {"", "", "'meshes':[{'primitives':[{'attributes':{'POSITION':'0'}}]}]", "POSITION",
         "not a non-negative integer"},
        {"", "", "'meshes':{}", "meshes", "not an array"},
        {"", "", "'meshes':[7]", "mesh 0", "not an object"},
    };
    CHECK(cases, NULL, 0);
}

static void vertices_that_are_not_finite(void **state)
{
    (void)state;
    static const bad_case cases[] = {
        {",{'buffer':0,'byteOffset':92,'byteLength':36}",
         ",{'bufferView':3,'componentType':5126,'type':'VEC3','count':3}",
         "'meshes':[{'name':'leaf','primitives':[{'attributes':{'POSITION':3}}]}]",
         "mesh 0 \"leaf\", primitive 0", "accessor 3: element 1 is not finite"},
    };
    float positions[9] = {0, 0, 0, 1, NAN, 0, 0, 1, 0};
    CHECK(cases, positions, sizeof positions);
    positions[4] = -INFINITY;
    CHECK(cases, positions, sizeof positions);
}

static void bad_materials(void **state)
{
    (void)state;
#define IMAGE(uri) "'textures':[{'source':0}],'images':[{'name':'bark','uri':'" uri "'}],"
#define USED       "'materials':[{'pbrMetallicRoughness':{'baseColorTexture':{'index':0}}}]"
    static const bad_case cases[] = {
        {"", "", "'materials':[{},{'name':'leaf','alphaMode':'MASK','alphaCutoff':1.5}]",
         "material 1 \"leaf\"", "alphaCutoff 1.5 is outside 0 to 1"},
        {"", "", "'materials':[{'alphaCutoff':-0.1}]", "material 0", "outside 0 to 1"},
        {"", "", "'materials':[{'alphaCutoff':1e999}]", "material 0", "finite"},
        {"", "", "'materials':[{'alphaMode':'SOLID'}]", "material 0", "unknown alphaMode"},
        {"", "", "'materials':[{'doubleSided':1}]", "doubleSided", "true or false"},
        {"", "", "'materials':[{'pbrMetallicRoughness':{'baseColorFactor':[1,1,1]}}]",
         "baseColorFactor", "3 numbers instead of 4"},
        {"", "", "'materials':[{'pbrMetallicRoughness':{'baseColorFactor':[1,1,1,2]}}]",
         "baseColorFactor", "outside 0 to 1"},
        {"", "", "'materials':[{'pbrMetallicRoughness':{'baseColorTexture':{'index':3}}}]",
         "material 0", "the count is 0"},
        {"", "", "'textures':[{}]," USED, "texture 0", "no PNG, JPEG or WebP"},
        {"", "",
         "'samplers':[{'wrapT':7}],'textures':[{'source':0,'sampler':0}],"
         "'images':[{'uri':'x'}]," USED,
         "sampler 0", "wrapT 7"},
        {"", "", "'textures':[{'source':0}],'images':[{}]," USED, "image 0",
         "neither a URI nor a bufferView"},
        {"", "", IMAGE("bark.png") USED, "image 0 \"bark\"", "a scene in memory cannot read files"},
        {"", "", IMAGE("http://host/bark.png") USED, "image 0 \"bark\"", "only files beside"},
        {"", "", IMAGE("data:image/png,xyz") USED, "image 0 \"bark\"", "not base64"},
        {"", "", IMAGE("data:;base64,iVB*") USED, "image 0 \"bark\"", "base64 at letter"},
        {"", "", IMAGE("data:;base64,iVBORw0KGgoAAAANSUhEUgAAAAIAAAABCAYA") USED,
         "image 0 \"bark\"", "PNG: "},
        {"", "", IMAGE("data:;base64,R0lGODlh") USED, "(memory): image 0 \"bark\"",
         "neither PNG nor JPEG nor WebP"},
    };
    CHECK(cases, NULL, 0);
}

static void bad_nodes(void **state)
{
    (void)state;
    static const bad_case cases[] = {
        {"", "", "'nodes':[{'children':[1]},{'name':'b','children':[2]},{'children':[1]}]",
         "node 2: its child 1", "a child of node 0 too"},
        {"", "", "'nodes':[{'name':'a','children':[1]},{'children':[2]},{'children':[0]}]",
         "node 0 \"a\"", "its own ancestor"},
        {"", "", "'nodes':[{},{'children':[1]}],'scenes':[{'nodes':[0]}]", "node 1",
         "its own ancestor"},
        {"", "", "'nodes':[{'children':[4]}]", "node 0", "there is no node 4"},
        {"", "", "'nodes':[{'children':[1]},{}],'scenes':[{'nodes':[1]}]", "scene 0",
         "a child of node 0"},
        {"", "", "'nodes':[{},{}],'scenes':[{'nodes':[0,0]}]", "names node 0 twice", ""},
        {"", "", "'nodes':[{}],'scenes':[{'nodes':[0,0]}]", "scene 0", "twice"},
        {"", "", "'nodes':[{}],'scenes':[{}],'scene':1", "there is no scene 1", "the count is 1"},
        {"", "", "'nodes':[{'mesh':0}]", "node 0", "the count is 0"},
        {"", "", "'nodes':[{'matrix':[1,0,0]}]", "node 0", "3 numbers instead of 16"},
        {"", "", "'nodes':[{'matrix':[1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1],'scale':[1,1,1]}]", "node 0",
         "both a matrix"},
        {"", "", "'nodes':[{'matrix':[1,0,0,1,0,1,0,0,0,0,1,0,0,0,0,1]}]", "node 0", "(memory)"},
        {"", "", "'nodes':[{'rotation':[0,0,0,0]}]", "node 0", "rotation"},
        {"", "", "'nodes':[{'translation':[1e39,0,0]}]", "translation", "finite"},
        {"", "", "'nodes':[{'camera':0}],'cameras':[{'type':'perspective'}]", "node 0",
         "perspective is missing"},
        {"", "", "'nodes':[{'camera':0}],'cameras':[{'type':'fisheye'}]", "node 0", "fisheye"},
        {"", "",
         "'nodes':[{'camera':0}],'cameras':[{'type':'perspective','perspective':"
         "{'yfov':4}}]",
         "node 0", "yfov is 4"},
        {"", "", "'nodes':[{'extensions':{'KHR_lights_punctual':{'light':0}}}]", "node 0",
         "the count is 0"},
        {"", "",
         "'nodes':[{'extensions':{'KHR_lights_punctual':{'light':0}}}],'extensions':"
         "{'KHR_lights_punctual':{'lights':[{'type':'area'}]}}",
         "light 0", "unknown type \"area\""},
        {"", "",
         "'nodes':[{'extensions':{'KHR_lights_punctual':{'light':0}}}],'extensions':"
         "{'KHR_lights_punctual':{'lights':[{'type':'spot','spot':{'innerConeAngle':1,"
         "'outerConeAngle':0.5}}]}}",
         "node 0", "cone angles"},
        {"", "",
         MESH "'nodes':[{'mesh':0,'extensions':{'EXT_mesh_gpu_instancing':{'attributes':"
              "{'TRANSLATION':0,'SCALE':3}}}}]",
         "SCALE: there is no accessor 3", "the count is 3"},
        {"", ",{'componentType':5126,'type':'VEC3','count':60000}",
         MESH "'nodes':[{'mesh':0,'extensions':{'EXT_mesh_gpu_instancing':{'attributes':"
              "{'TRANSLATION':3}}}}]",
         "accessor 3", "no bufferView"},
    };
    CHECK(cases, NULL, 0);
}

static void bad_animations(void **state)
{
    (void)state;
    static const float times[3] = {0, 1, 1};
#define CHANNEL(path) "'channels':[{'sampler':0,'target':{'node':0,'path':'" path "'}}]"
    static const bad_case cases[] = {
        {",{'buffer':0,'byteOffset':92,'byteLength':12}",
         ",{'bufferView':3,'componentType':5126,'type':'SCALAR','count':3},"
         "{'bufferView':0,'componentType':5126,'type':'VEC3','count':3}",
         "'nodes':[{}],'animations':[{'name':'walk','samplers':[{'input':3,'output':4}]," CHANNEL(
             "translation") "}]",
         "animation 0 \"walk\", channel 0", "key 2"},
        {"", "",
         "'nodes':[{}],'animations':[{'samplers':[{'input':0,'output':0}]," CHANNEL("scale") "}]",
         "accessor 0", "3 components an element instead of 1"},
        {",{'buffer':0,'byteOffset':92,'byteLength':8}",
         ",{'bufferView':3,'componentType':5126,'type':'SCALAR','count':2}",
         "'nodes':[{}],'animations':[{'samplers':[{'input':3,'output':0,'interpolation':"
         "'CUBICSPLINE'}]," CHANNEL("scale") "}]",
         "accessor 0 has 4 values", "2 keys instead of 6"},
        {"", "", "'nodes':[{}],'animations':[{'samplers':[{'input':0}]," CHANNEL("scale") "}]",
         "animation 0, channel 0", "no input or output"},
        {"", "",
         "'nodes':[{}],'animations':[{'samplers':[{'input':0,'output':0,'interpolation':"
         "'SMOOTH'}]," CHANNEL("scale") "}]",
         "animation 0, channel 0", "SMOOTH"},
        {"", "", "'nodes':[{}],'animations':[{" CHANNEL("scale") "}]", "sampler 0",
         "the count is 0"},
        {"", "",
         "'nodes':[{'matrix':[1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1]}],'animations':[{'samplers':["
         "{'input':0,'output':0}]," CHANNEL("scale") "}]",
         "animates node 0", "matrix"},
    };
    CHECK(cases, times, sizeof times);
}

static void extensions_and_versions(void **state)
{
    (void)state;
    static const bad_case cases[] = {
        {"", "", "'extensionsRequired':['KHR_draco_mesh_compression']", "requires",
         "KHR_draco_mesh_compression"},
        {"", "", "'extensionsRequired':['EXT_meshopt_compression']", "requires",
         "EXT_meshopt_compression"},
        {"", "", "'extensionsRequired':[7]", "extensionsRequired", "strings"},
    };
    CHECK(cases, NULL, 0);
    static const char *const documents[][2] = {
        {"", "not valid JSON"},
        {"{", "not valid JSON"},
        {"[]", "not an object"},
        {"{}", "asset.version is missing"},
        {"{\"asset\":{\"version\":\"1.0\"}}", "version 1.0 is not supported"},
        {"{\"asset\":{\"version\":\"2.1\",\"minVersion\":\"2.1\"}}", "version 2.1"},
        {"{\"asset\":{\"version\":\"2.0\"}} more", "not valid JSON at byte 28"}};
    for (size_t i = 0; i < sizeof documents / sizeof *documents; i++)
        assert_bad_bytes(documents[i][0], strlen(documents[i][0]), "(memory): ", documents[i][1]);
}

/* Files ------------------------------------------------------------------------------------- */

static void assert_load_fails(const char *path, gn_result expected, const char *reason)
{
    gn_scene *scene = NULL;
    const gn_result result = gn_scene_load(test_device(), path, &scene);
    const char *message = gn_device_message(test_device());
    assert_null(scene);
    if (result != expected)
        fail_msg("%s: result %d, not %d: %s", path, (int)result, (int)expected, message);
    if (!strstr(message, path) || !strstr(message, reason))
        fail_msg("\"%s\" does not hold \"%s\" and \"%s\"", message, path, reason);
}

static void missing_files(void **state)
{
    (void)state;
    assert_load_fails("/tmp/gnomon-no-such.glb", GN_ERROR_IO, "No such file");
    assert_load_fails("/tmp/gnomon-no-such.gltf", GN_ERROR_IO, "No such file");
    assert_load_fails("/tmp/gnomon-no-such.obj", GN_ERROR_IO, "No such file");

    char folder[] = "/tmp/gnomon-bad-XXXXXX", path[128];
    assert_non_null(mkdtemp(folder));
    snprintf(path, sizeof path, "%s/folder.glb", folder);
    assert_int_equal(mkdir(path, 0700), 0);
    assert_load_fails(path, GN_ERROR_IO, "not a regular file");
    rmdir(path);

    snprintf(path, sizeof path, "%s/scene.gltf", folder);
    static const char texture[] =
        "{\"asset\":{\"version\":\"2.0\"},\"images\":[{\"uri\":\"leaves/oak.png\"}],"
        "\"textures\":[{\"source\":0}],\"materials\":[{\"pbrMetallicRoughness\":"
        "{\"baseColorTexture\":{\"index\":0}}}]}";
    write_file(path, texture, sizeof texture - 1);
    assert_load_fails(path, GN_ERROR_IO,
                      "image 0: \"leaves/oak.png\" cannot be read: No such file");
    static const char percent[] =
        "{\"asset\":{\"version\":\"2.0\"},\"images\":[{\"uri\":\"oak%2.png\"}],"
        "\"textures\":[{\"source\":0}],\"materials\":[{\"pbrMetallicRoughness\":"
        "{\"baseColorTexture\":{\"index\":0}}}]}";
    write_file(path, percent, sizeof percent - 1);
    assert_load_fails(path, GN_ERROR_FORMAT, "\"oak%2.png\" is not a valid URI");
    static const char empty[] = "{\"asset\":{\"version\":\"2.0\"}}";
    write_file(path, empty, sizeof empty - 1);
    assert_load_fails(path, GN_ERROR_FORMAT, "no triangles");
    unlink(path);
    rmdir(folder);
}

/* Other formats: OBJ through Assimp. */
static void other_formats(void **state)
{
    (void)state;
    char folder[] = "/tmp/gnomon-bad-XXXXXX", path[128], library[128];
    assert_non_null(mkdtemp(folder));
    snprintf(path, sizeof path, "%s/scene.obj", folder);
    snprintf(library, sizeof library, "%s/scene.mtl", folder);
    static const char object[] = "mtllib scene.mtl\nv 0 0 0\nv 2 0 0\nv 2 3 0\nv 0 3 0\n"
                                 "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nusemtl bark\n"
                                 "f 1/1 2/2 3/3 4/4\n";
    static const char material[] = "newmtl bark\nKd 0.5 0.25 1\n";
    write_file(path, object, sizeof object - 1);
    write_file(library, material, sizeof material - 1);
    gn_scene *scene = NULL;
    if (gn_scene_load(test_device(), path, &scene) != GN_OK)
        fail_msg("%s", gn_device_message(test_device()));
    const gn_scene_info info = gn_scene_get_info(scene);
    assert_int_equal(info.triangles, 2);
    assert_int_equal(info.materials, 1); /* not the one Assimp makes up */
    assert_floats(scene->materials[0].desc.base_color, (float[]){0.5f, 0.25f, 1, 1}, 4, 1e-6f);
    assert_floats(info.bounds_max, (float[]){2, 3, 0}, 3, 1e-6f);
    const gn_part *part = &scene->meshes[0].parts[0];
    for (uint32_t i = 0; i < part->vertex_count; i++) /* v runs down here, up there */
        assert_floats(part->uvs + 2 * i,
                      (float[]){part->positions[3 * i] / 2, 1 - part->positions[3 * i + 1] / 3}, 2,
                      1e-6f);
    gn_scene_destroy(&scene);

    static const char textured[] = "newmtl bark\nmap_Kd oak.png\n";
    write_file(library, textured, sizeof textured - 1);
    assert_load_fails(path, GN_ERROR_IO, "texture \"oak.png\" cannot be read: No such file");
    write_file(path, "v 0 0 0\n", 8);
    gn_scene *none = NULL;
    assert_int_not_equal(gn_scene_load(test_device(), path, &none), GN_OK);
    assert_non_null(strstr(gn_device_message(test_device()), path));
    unlink(path);
    unlink(library);
    rmdir(folder);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(truncated_at_every_byte), cmocka_unit_test(truncated_files),
        cmocka_unit_test(every_byte_changed),      cmocka_unit_test(wrong_lengths),
        cmocka_unit_test(bad_accessors),           cmocka_unit_test(vertices_that_are_not_finite),
        cmocka_unit_test(bad_materials),           cmocka_unit_test(bad_nodes),
        cmocka_unit_test(bad_animations),          cmocka_unit_test(extensions_and_versions),
        cmocka_unit_test(missing_files),           cmocka_unit_test(other_formats),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
