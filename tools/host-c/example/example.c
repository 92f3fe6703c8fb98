/*
 * The least that a program does with dermis: a character in a pose, its skin read back. No Vulkan of its own.
 *
 *     cc example.c $(pkg-config --cflags --libs dermis) -o example && ./example CHARACTER.glb [SECONDS]
 */

#include <stdio.h>
#include <stdlib.h>

#include <dermis.h>

static void check(dm_result result)
{
    if (result == DM_OK)
        return;
    fprintf(stderr, "%s\n", dm_last_error());
    exit(1);
}

/* The best Vulkan device, or the CPU where there is none. */
static dm_context create_context(void)
{
    dm_context_desc desc = {0};
    dm_context context;
    dm_result result;
    desc.size = sizeof desc;
    desc.api_version = DM_API_VERSION;
    result = dm_context_create(&desc, &context);
    if (result == DM_ERROR_NO_DEVICE) {
        desc.flags = DM_CONTEXT_CPU;
        result = dm_context_create(&desc, &context);
    }
    check(result);
    return context;
}

int main(int count, char **words)
{
    dm_context context;
    dm_rig rig;
    dm_rig_info info = {0};
    dm_deformer deformer;
    dm_skin skin = {0};
    float *pose;
    uint32_t row, contacts = 0;

    if (count < 2) {
        fprintf(stderr, "usage: example CHARACTER.glb [SECONDS]\n");
        return 1;
    }
    context = create_context();
    check(dm_rig_load(words[1], NULL, &rig));
    info.size = sizeof info;
    check(dm_rig_get_info(rig, &info));
    check(dm_deformer_create(context, rig, NULL, &deformer));

    pose = malloc(sizeof *pose * 16 * info.joints);
    skin.size = sizeof skin;
    skin.vertices = info.vertices;
    skin.positions = malloc(sizeof(float) * 3 * info.vertices);
    skin.states = malloc(info.vertices);
    if (!pose || !skin.positions || !skin.states)
        return 1;
    check(dm_rig_pose_clip(rig, 0, count > 2 ? (float)atof(words[2]) : 0.5f, pose, info.joints));
    check(dm_deformer_advance(deformer, pose, info.joints));
    check(dm_deformer_read(deformer, &skin));
    for (row = 0; row < info.vertices; row++)
        contacts += skin.states[row] == 2;
    printf("%u of %u vertices are in contact\n", contacts, info.vertices);

    free(skin.states);
    free(skin.positions);
    free(pose);
    check(dm_deformer_destroy(deformer));
    check(dm_rig_destroy(rig));
    check(dm_context_destroy(context));
    return 0;
}
