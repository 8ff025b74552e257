/* What an embedder does first: a device, a scene, one frame. */
#include <gnomon/gnomon.h>
#include <stdio.h>

int main(void)
{
    gn_device *device = NULL;
    gn_scene *scene = NULL;
    gn_view *view = NULL;
    gn_procedural_desc small = gn_procedural_desc_default();
    small.scale = 0.01;
    gn_view_desc size = gn_view_desc_default();
    size.width = 64;
    size.height = 36;
    const gn_visibility_desc how = gn_visibility_desc_default();
    const uint32_t light = 0;

    if (gn_device_create(NULL, &device) != GN_OK)
        return 1;
    if (gn_scene_create_procedural(device, "grove", &small, &scene) != GN_OK ||
        gn_view_create(device, &size, &view) != GN_OK ||
        gn_view_render(view, scene, 0, &how, &light, 1) != GN_OK) {
        fprintf(stderr, "%s\n", gn_device_message(device));
        return 1;
    }
    const float *visibility = gn_view_visibility(view, 0);
    unsigned lit = 0;
    for (unsigned i = 0; i < size.width * size.height; i++)
        lit += visibility[i] > 0.5f;
    printf("%u of %u pixels are lit\n", lit, size.width * size.height);

    gn_view_destroy(&view);
    gn_scene_destroy(&scene);
    gn_device_destroy(&device);
    return lit > 0 ? 0 : 1;
}
