#ifndef KD_APP_APP_H
#define KD_APP_APP_H

#define KD_VERSION "0.1.0"

#endif
