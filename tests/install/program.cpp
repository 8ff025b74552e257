// The same headers and the same library from C++.
#include <gnomon/gnomon.h>
#include <gnomon/shadow/alpha.h>
#include <gnomon/shadow/ray_cone.h>

#include <cstdio>

int main()
{
    gn_device *device = nullptr;
    if (gn_device_create(nullptr, &device) != GN_OK)
        return 1;
    const gn_device_info info = gn_device_get_info(device);
    const gn_ray_cone cone = gn_ray_cone_propagate(gn_ray_cone{0.0f, 0.001f}, 10.0f);
    std::printf("%s, %s, a cone of %g m, opacity %g\n", gn_method_find("ray")->name, info.isa_name,
                double(cone.width), double(gn_alpha_saturate(0.25f, 0.5f)));
    gn_device_destroy(&device);
    return 0;
}
