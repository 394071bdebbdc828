"""A finished data set in the formats of other tools: COCO, MOTChallenge, WebDataset, Parquet."""
