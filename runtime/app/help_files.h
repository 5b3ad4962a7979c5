#ifndef KD_APP_HELP_FILES_H
#define KD_APP_HELP_FILES_H

/* What is installed beside the program, made from the tables that parse the command line. */

/** Print the manual page, in man(7) macros, to standard output. */
void app_manual_print(void);

/** Print the completion script for bash to standard output. */
void app_completion_print(void);
/** The same for zsh. */
void app_zsh_completion_print(void);

#endif
