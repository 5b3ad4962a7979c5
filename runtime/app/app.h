#ifndef KD_APP_APP_H
#define KD_APP_APP_H

#define KD_VERSION "0.1.0"

/** Run the program: `kandil COMMAND …`.
 *
 *  Returns the exit code: 0 done, 1 the work failed, 2 the command line is wrong, 130 interrupted
 */
int kd_app_main(int argc, char **argv);

#endif
