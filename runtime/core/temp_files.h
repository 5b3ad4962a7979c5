#ifndef KD_CORE_TEMP_FILES_H
#define KD_CORE_TEMP_FILES_H

/* Files that stand under another name until they are whole, known to whoever has to end the process at once.
 */

/** Remember a file; what does not fit into the list is not remembered. Threading: any */
void kd_temp_files_add(const char *path);
/** Forget it: it has its name, or is gone. Threading: any */
void kd_temp_files_forget(const char *path);
/** Remove all that are remembered. Threading: any, and from signal handlers; the process is to end */
void kd_temp_files_remove(void);

#endif
