#ifndef KD_APP_EXTENSION_H
#define KD_APP_EXTENSION_H

/* The whole program with what others add to it: components that scripts, panels and snapshots know, and
 * systems that stand in the frame's graph and in the profile like the built-in ones.
 *
 *     int main(int argc, char **argv)
 *     {
 *         return kd_main(argc, argv, &(kd_extension){.name = "my_game",
 *                                                    .register_components = register_components,
 *                                                    .import_systems = import_systems});
 *     }
 */

#include "runtime/ecs/system.h"
#include "runtime/gpu/embedded.h"

typedef struct kd_extension {
    const char *name; /* in messages */
    /* Give the world what scripts may name: KD_ID(w, spin) for each. Called once a world; NULL: nothing. */
    void (*register_components)(kd_world *w);
    /* Add systems to the schedule, behind the built-in ones of the same phase; NULL: none. `kandil reference`
     * leaves those of the GPU lane out. A status other than KD_OK, said with kd_fail, ends the program. */
    kd_status (*import_systems)(kd_schedule *s);
    /* Shaders of the extension, ended by an empty row, named "shaders/NAME/…"; NULL: none. With
     * KANDIL_SHADER_DIR set, a file of that name in the folder is taken instead. */
    const kd_embedded_shader *shaders;
} kd_extension;

/** Run the program: `PROGRAM COMMAND …`, see `kandil help`.
 *
 *  extension  NULL: kandil as it is. Must outlive the call
 *  Returns the exit code: 0 done, 1 the work failed, 2 the command line is wrong, 130 interrupted
 */
int kd_main(int argc, char **argv, const kd_extension *extension);

#endif
