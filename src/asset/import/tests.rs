//! Tests of the importer on whole files.
