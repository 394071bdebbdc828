"""The files of a data set: their names, codecs, tables, checksums and the manifest."""
